"""Defects of a .ssp or an FMU are refused with what, where and how to mend."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from flexhex.ssp.fmu import binary_path
from tests.gateway.archives import changed, edited, member, shared_library, wire, with_fmu
from tests.gateway.cargo import built
from tests.ssp.archives import heavy

SSD = "SystemStructure.ssd"
XML = "modelDescription.xml"
FEEDBACK, PLANT = "resources/feedback.fmu", "resources/plant.fmu"
BINARY = binary_path("feedback")


def refusal(*arguments: object) -> str:
    """Error text of the example program; never a panic."""
    program = built() / "examples" / "closed_loop"
    words = [str(program), "--seconds", "0.01", *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 3, f"{done.returncode}: {done.stdout}{done.stderr}"
    assert "panicked" not in done.stderr
    return done.stderr


def edited_fmu(ssp: bytes, old: str, new: str) -> bytes:
    """A .ssp with text replaced in feedback's modelDescription.xml."""
    text = member(member(ssp, FEEDBACK), XML).decode()
    assert old in text, old
    return with_fmu(ssp, FEEDBACK, {XML: text.replace(old, new).encode()})


def other_platforms(ssp: bytes) -> bytes:
    """feedback.fmu for Windows and Mac only."""
    changes = {
        BINARY: None,
        "binaries/win64/feedback.dll": b"MZ",
        "binaries/darwin64/feedback.dylib": b"",
    }
    return with_fmu(ssp, FEEDBACK, changes)


THETA = wire("plant.theta[2]", "feedback.theta[2]")


def without_theta(ssp: bytes) -> bytes:
    """A .ssp without one connection."""
    text = member(ssp, SSD).decode()
    left, count = re.subn(re.escape(THETA) + r"(/>|>.*?</ssd:Connection>)", "", text, flags=re.S)
    assert count == 1
    return changed(ssp, {SSD: left.encode()})


GUID = '<fmiModelDescription fmiVersion="2.0" modelName="feedback" guid="{'
TS = '<ssv:Parameter name="Ts">\n      <ssv:Real value="0.00025"'
KIND = '<ssv:Parameter name="kind">\n      <ssv:Integer value="0"'

CASES: dict[str, tuple[Callable[[bytes], bytes], tuple[str, ...]]] = {
    "no zip": (lambda s: b"hello", ("not a zip archive",)),
    "truncated": (lambda s: s[: len(s) // 2], ("not a zip archive, or a truncated one",)),
    "no system": (lambda s: changed(s, {SSD: None}), (SSD, "is missing in the archive")),
    "no xml": (lambda s: changed(s, {SSD: b"<a"}), (SSD, "not valid XML")),
    "entities": (
        lambda s: changed(s, {SSD: b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>'}),
        (SSD, "not valid XML", "DTD"),
    ),
    "other xml": (lambda s: changed(s, {SSD: b"<a/>"}), ("no SSP 1.x system description",)),
    "nested": (
        lambda s: edited(s, SSD, ("<ssd:Elements>", '<ssd:Elements><ssd:System name="inner"/>')),
        ("nested systems",),
    ),
    "no FMU": (
        lambda s: edited(s, SSD, ('type="application/x-fmu-sharedlibrary"', 'type="a/b"')),
        ("component type 'a/b' is no FMU",),
    ),
    "twice": (
        lambda s: edited(s, SSD, ('Component name="N_E"', 'Component name="N_F"')),
        ("component 'N_F' exists twice", "rename one"),
    ),
    "another unit": (
        lambda s: edited(
            s,
            "resources/feedback.ssv",
            (f'{TS} unit="s"', TS.replace("0.00025", "0.25") + ' unit="ms"'),
        ),
        ("feedback", "Ts = 0.25 ms: write the value in s"),
    ),
    "unknown component": (
        lambda s: edited(s, SSD, (THETA, THETA.replace('"plant"', '"plnat"'))),
        ("plnat.theta[2] -> feedback.theta[2]", "did you mean 'plant'?"),
    ),
    "unknown variable": (
        lambda s: edited(s, SSD, (THETA, wire("plant.theta[7]", "feedback.theta[2]"))),
        ("in plant: there is no variable 'theta[7]', did you mean 'theta[",),
    ),
    "from an input": (
        lambda s: edited(s, SSD, (THETA, wire("plant.tau[2]", "feedback.theta[2]"))),
        ("plant.tau[2] is of causality input; a connection starts at an output",),
    ),
    "units": (
        lambda s: edited(s, SSD, (THETA, wire("plant.tau_meas[2]", "feedback.theta[2]"))),
        ("'N m' into 'rad', units must be equal",),
    ),
    "fed twice": (
        lambda s: edited(s, SSD, (THETA, wire("plant.theta[2]", "feedback.theta[3]"))),
        ("feedback.theta[3] is fed by", "keep one connection"),
    ),
    "unfed": (without_theta, ("feedback.theta[2]: not connected",)),
    "no number": (
        lambda s: edited(s, "resources/feedback.ssv", (TS, TS.replace("0.00025", "nan"))),
        ("parameter 'Ts' has no finite value: 'nan'",),
    ),
    "old name in a set": (
        lambda s: edited(s, "resources/K.ssv", ('"p0.actuator[1].k"', '"p0[2]"')),
        ("K: there is no variable 'p0[2]', it is called 'p0.actuator[1].k'",),
    ),
    "old name in a wire": (
        lambda s: edited(s, SSD, ('endConnector="p.upper.J[1]"', 'endConnector="p[133]"')),
        ("no variable 'p[133]', it is called 'p.upper.J[1]'",),
    ),
    "no item": (
        lambda s: edited(
            s,
            "resources/reference.ssv",
            (KIND, KIND.replace('Integer value="0"', 'Real value="0.5"')),
        ),
        ("kind = 0.5", "must be one of 0 setpoints, 1 triangle"),
    ),
    "broken step": (
        lambda s: edited(s, "resources/feedback.ssv", (TS, TS.replace("0.00025", "0.0006"))),
        ("feedback: Ts = 0.0006 s is 2.4", "base steps of 0.00025 s", "change Ts"),
    ),
    "out of range": (
        lambda s: edited(s, "resources/feedback.ssv", (TS, TS.replace("0.00025", "20000"))),
        ("feedback: fmi2SetReal of parameters", "Ts"),
    ),
    "base step": (
        lambda s: edited(s, SSD, ('baseStep="0.00025"', 'baseStep="-1"')),
        ("Schedule is '-1', must be a positive number of seconds",),
    ),
    "no such FMU": (
        lambda s: changed(s, {FEEDBACK: None}),
        ("resources/feedback.fmu is missing in the archive",),
    ),
    "broken FMU": (
        lambda s: changed(s, {FEEDBACK: b"hello"}),
        ("resources/feedback.fmu: not a zip archive",),
    ),
    "FMI 3": (
        lambda s: edited_fmu(s, 'fmiVersion="2.0"', 'fmiVersion="3.0"'),
        ("FMI 3.0, co-simulation: export it for FMI 2.0 co-simulation",),
    ),
    "model exchange": (
        lambda s: edited_fmu(s, "CoSimulation", "ModelExchange"),
        ("FMI 2.0, no co-simulation",),
    ),
    "file outside": (
        lambda s: edited_fmu(s, 'modelIdentifier="feedback"', 'modelIdentifier="../feedback"'),
        ("modelIdentifier '../feedback' is no name of a file",),
    ),
    "another GUID": (
        lambda s: edited_fmu(s, GUID, GUID + "0"),
        ("feedback: fmi2Instantiate", "GUID", "build the FMU anew"),
    ),
    "FMUs that are too much together": (
        lambda s: changed(s, {f: heavy(member(s, f), 600 * 2**20) for f in (FEEDBACK, PLANT)}),
        ("with its FMU the system unpacks to 12", " MB, at most 1024 MB are opened"),
    ),
    "other platforms": (
        other_platforms,
        ("feedback.fmu: holds binaries for darwin64, win64, none for this machine", "build"),
    ),
    "no platform": (
        lambda s: with_fmu(s, FEEDBACK, {BINARY: None}),
        ("feedback.fmu: holds no binary at all",),
    ),
    "no library": (
        lambda s: with_fmu(s, FEEDBACK, {BINARY: b"hello"}),
        ("feedback: ", "its library does not load"),
    ),
}


@pytest.mark.sample(12)
@pytest.mark.parametrize(("spoil", "said"), CASES.values(), ids=CASES.keys())
def test_a_package_is_refused_in_words(
    spoil: Callable[[bytes], bytes], said: tuple[str, ...], hexapod_ssp: Path, tmp_path: Path
) -> None:
    package = tmp_path / "spoiled.ssp"
    package.write_bytes(spoil(hexapod_ssp.read_bytes()))
    text = refusal(package)
    assert [words for words in said if words not in text] == [], text


def test_a_library_that_is_no_fmu_is_refused(hexapod_ssp: Path, tmp_path: Path) -> None:
    source = tmp_path / "empty.c"
    source.write_text("extern int nothing;\nint nothing = 0;\n")
    library = shared_library(source, tmp_path).read_bytes()
    package = tmp_path / "empty.ssp"
    package.write_bytes(with_fmu(hexapod_ssp.read_bytes(), FEEDBACK, {BINARY: library}))
    assert "its library lacks the function fmi2Instantiate" in refusal(package)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--host", "drives"], "there is no component 'drives', there are reference, N_F"),
        (["--host", "plnat"], "did you mean 'plant'?"),
        (["--host", "K"], "K: has no output theta[1]"),
        (["--own-thread", "E"], "there is no component 'E'"),
        (["--own-thread", "plant"], "plant: is the component of the machine"),
        (["--plant", "no.fmu"], "no.fmu: cannot be read"),
    ],
    ids=lambda value: "" if isinstance(value, str) else " ".join(value),
)
def test_an_option_is_refused_in_words(arguments: list[str], said: str, hexapod_ssp: Path) -> None:
    text = refusal(hexapod_ssp, *arguments)
    assert said in text


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    assert "none.ssp: cannot be read" in refusal(tmp_path / "none.ssp")


def test_an_fmu_of_another_interface_does_not_stand_in(hexapod_ssp: Path, tmp_path: Path) -> None:
    fmu = tmp_path / "feedback.fmu"
    fmu.write_bytes(member(hexapod_ssp.read_bytes(), FEEDBACK))
    text = refusal(hexapod_ssp, "--plant", fmu)
    assert "feedback.fmu: connection" in text
    assert "in plant: " in text


def test_what_only_the_plant_can_give_is_refused_for_drives(
    hexapod_ssp: Path, tmp_path: Path
) -> None:
    pose = (wire("W.theta_f[1]", "N_E.theta[1]"), wire("plant.phi_E.x", "N_E.theta[1]"))
    package = tmp_path / "pose.ssp"
    package.write_bytes(edited(hexapod_ssp.read_bytes(), SSD, pose))
    text = refusal(package)
    assert "connection plant.phi_E.x -> N_E.theta[1]: drives measure theta" in text
