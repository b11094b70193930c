"""XML of the SSP standard: namespaces, safe parsing, elements with `ssd:` names."""

from __future__ import annotations

from typing import Any

from lxml import etree

from flexhex.fmus.common.errors import InterfaceError

SSP = "http://ssp-standard.org/SSP1/"
NAMESPACES = {
    "ssd": SSP + "SystemStructureDescription",
    "ssc": SSP + "SystemStructureCommon",
    "ssv": SSP + "SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "flexhex": "urn:flexhex:schedule",
}


def parse(text: bytes, where: str) -> Any:
    """Root element; InterfaceError with the line when the text is no XML.

    Entities and the network stay off, so that a foreign file cannot reach anything.
    """
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise InterfaceError(f"{where}: not valid XML: {error.msg}") from None


def root(tag: str, prefixes: tuple[str, ...], **attributes: str) -> Any:
    """A root element, `ssd:System` style, that declares these prefixes."""
    return etree.Element(_qualified(tag), attributes, nsmap={p: NAMESPACES[p] for p in prefixes})


def child(parent: Any, tag: str, **attributes: str) -> Any:
    """A new last child of parent; tag as `ssd:Component`."""
    return etree.SubElement(parent, _qualified(tag), attributes)


def text_of(element: Any) -> bytes:
    """The document, indented, in UTF-8."""
    return bytes(etree.tostring(element, pretty_print=True, xml_declaration=True, encoding="UTF-8"))


def _qualified(tag: str) -> str:
    prefix, _, name = tag.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{name}"
