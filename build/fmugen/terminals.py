"""terminalsAndIcons.xml: an array is one terminal, so that a tool can draw it as one connector."""

from __future__ import annotations

from lxml import etree

from flexhex.fmus.common.interface import Interface


def terminals(interface: Interface) -> bytes:
    """The XML text; the format is that of FMI 3.0, which FMI 2.0 archives carry along."""
    root = etree.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    parent = etree.SubElement(root, "Terminals")
    for variable in (*interface.inputs, *interface.outputs):
        if variable.size is None:
            continue
        terminal = etree.SubElement(
            parent,
            "Terminal",
            name=variable.name,
            matchingRule="sequence",
            description=f"{variable.causality}: {variable.description}",
        )
        for name in variable.scalar_names:
            etree.SubElement(
                terminal, "TerminalMemberVariable", variableName=name, variableKind="signal"
            )
    if not len(parent):
        root.remove(parent)
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
