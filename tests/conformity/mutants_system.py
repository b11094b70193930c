"""Mistakes in a system description, the hexapod's."""

from __future__ import annotations

from tests.conformity.archives import passage_out, text, without
from tests.conformity.mutations import Mutants

SSD = "SystemStructure.ssd"
SYSTEM: Mutants = {
    "input unfed": (
        passage_out(
            '<ssd:Connection startElement="reference" startConnector="payload" endElement="plant"',
            "</ssd:Connection>",
            SSD,
        ),
        "plant.payload: fed by nothing",
    ),
    "unit of a connector": (
        text('<ssc:Real unit="rad/s2"/>', '<ssc:Real unit="rad/s"/>', SSD),
        "unit rad/s in the system, rad/s2 in the FMU",
    ),
    "units at the ends of a wire": (
        text(
            'startConnector="r[1]" endElement="feedback"',
            'startConnector="rd[1]" endElement="feedback"',
            SSD,
        ),
        "rad/s into rad",
    ),
    "output and input exchanged": (
        text(
            '<ssd:Connector name="r[1]" kind="output">',
            '<ssd:Connector name="r[1]" kind="input">',
            SSD,
        ),
        "input in the system, output in the FMU",
    ),
    "connector that the FMU lacks": (
        text('<ssd:Connector name="rd[3]"', '<ssd:Connector name="rd[9]"', SSD),
        "no such variable",
    ),
    "connector twice": (
        text('<ssd:Connector name="rd[3]"', '<ssd:Connector name="rd[2]"', SSD),
        "2 connectors of that name",
    ),
    "importers told different steps": (
        text('fixedStepSize="0.00025"', 'fixedStepSize="0.0005"', SSD),
        r": oms:SimulationInformation fixedStepSize is 0.0005 s, flexhex:Schedule baseStep 0.00025",
    ),
    "libcosim told another step": (
        text('baseStepSize="0.00025"', 'baseStepSize="0.0005"', SSD),
        r": osp:FixedStepAlgorithm baseStepSize is 0.0005 s, flexhex:Schedule baseStep 0.00025 s",
    ),
    "step that OMSimulator does not find": (
        text(
            '<ssc:Annotation type="org.openmodelica">\n        <oms:Annotations>\n'
            '          <oms:SimulationInformation name="oms_ma_default" method',
            '<ssc:Annotation type="x"/><ssc:Annotation type="org.openmodelica">'
            '<oms:Annotations><oms:SimulationInformation name="oms_ma_default" method',
            SSD,
        ),
        "OMSimulator would step by 0.001 s",
    ),
    "connector that is not declared": (
        passage_out('<ssd:Connector name="rd[1]" kind="output">', "</ssd:Connector>", SSD),
        r"connection reference.rd\[1\] -> N_F.thetad\[1\]: reference declares no connector rd\[1\]",
    ),
    "schedule with another period": (
        text('component="N_F" steps="2"', 'component="N_F" steps="4"', SSD),
        "flexhex:Schedule: N_F every 4 base steps, its Ts says 2$",
    ),
    "schedule without a component": (
        text('<flexhex:Period component="N_F" steps="2"/>', "", SSD),
        "flexhex:Schedule lacks N_F$",
    ),
    "schedule of a stranger": (
        text('component="N_F" steps', 'component="N_G" steps', SSD),
        "flexhex:Schedule names 'N_G', no component",
    ),
    "stop before start": (
        text('startTime="0.0"', 'startTime="60.0"', SSD),
        "DefaultExperiment: from 60 s to 52 s, must end after it starts$",
    ),
    "value in another unit": (
        text('value="0.0005" unit="s"', 'value="0.5" unit="ms"', "resources/N_F.ssv"),
        "N_F.Ts = 0.5 ms, the FMU wants s",
    ),
    "sample time that is not whole": (
        text(
            '<ssv:Real value="0.0005" unit="s"/>',
            '<ssv:Real value="0.0006" unit="s"/>',
            "resources/F.ssv",
        ),
        "2.4 base steps",
    ),
    "parameter out of range": (
        text(
            'name="corrections">\n      <ssv:Integer value="1"',
            'name="corrections">\n      <ssv:Integer value="99"',
            "resources/N_F.ssv",
        ),
        "N_F.corrections = 99",
    ),
    "parameter that the FMU lacks": (
        text('name="corrections"', 'name="correction"', "resources/N_F.ssv"),
        "is set, but the FMU has no such",
    ),
    "wire to nowhere": (
        text(
            'endElement="N_F" endConnector="theta[2]"',
            'endElement="N_F" endConnector="phi[2]"',
            SSD,
        ),
        "no variable 'phi",
    ),
    "wired twice": (
        text(
            'endElement="N_F" endConnector="theta[2]"',
            'endElement="N_F" endConnector="theta[1]"',
            SSD,
        ),
        "is fed by",
    ),
    "parameter set without a source": (
        text('source="resources/N_F.ssv"', 'source=""', SSD),
        "neither a source nor ParameterValues",
    ),
    "number that is a flag": (
        text(
            '<ssv:Real value="0.0005" unit="s"/>',
            '<ssv:Boolean value="true"/>',
            "resources/N_F.ssv",
        ),
        "N_F.Ts = true, must be a finite number",
    ),
    "FMU missing": (without("resources/filter.fmu"), "filter.fmu is missing"),
    "element without a place": (
        text("<ssd:Connections>", "<ssd:Nonsense/><ssd:Connections>", SSD),
        "Nonsense",
    ),
}
