"""Values of parameter sets come in the FMU's unit, or not at all."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from flexhex.fmus.common.errors import InterfaceError
from flexhex.ssp.executor import run
from flexhex.ssp.parameters import Setting
from flexhex.ssp.read import period, read_ssp
from tests.ssp.archives import changed

MS = b'<ssc:Unit name="ms"><ssc:BaseUnit s="1" factor="0.001"/></ssc:Unit>'


def with_sample_time(path: Path, target: Path, text: bytes, units: bytes = b"") -> Path:
    """A copy in which b.ssv writes its sample time, 0.5 ms, in another way."""

    def change(files: dict[str, bytes]) -> None:
        was = files["resources/b.ssv"]
        now, count = re.subn(rb'value="0.0005" unit="s"', text, was)
        assert count == 1
        files["resources/b.ssv"] = now.replace(b"<ssv:Units>", b"<ssv:Units>" + units)

    return changed(path, target, change)


def test_value_in_another_unit_is_converted(ring_ssp: Path, tmp_path: Path) -> None:
    """The executor steps b at the same ticks; 0.5 s had been taken for 0.5 ms."""
    path = with_sample_time(ring_ssp, tmp_path / "x.ssp", b'value="0.5" unit="ms"', MS)
    package = read_ssp(path)
    assert period(package.instance("b"), package.base) == 2
    same, wanted = (run(p, 0.05, signals=["b"])["b.y"] for p in (path, ring_ssp))
    assert same.tobytes() == wanted.tobytes()


@pytest.mark.parametrize(
    ("text", "units", "says"),
    [
        (
            b'value="0.5" unit="ms"',
            b"",
            r"x.ssp: b.Ts = 0.5 ms, the FMU wants s, and no ssc:Unit says what ms is:"
            r" write the value in s$",
        ),
        (
            b'value="0.5" unit="ms"',
            MS.replace(b's="1"', b'm="1"'),
            r"x.ssp: b.Ts = 0.5 ms, the FMU wants s, which is another quantity$",
        ),
    ],
)
def test_value_that_cannot_be_converted_is_refused(
    ring_ssp: Path, tmp_path: Path, text: bytes, units: bytes, says: str
) -> None:
    with pytest.raises(InterfaceError, match=says):
        read_ssp(with_sample_time(ring_ssp, tmp_path / "x.ssp", text, units))


def test_value_without_a_unit_is_in_the_fmus(ring_ssp: Path, tmp_path: Path) -> None:
    path = with_sample_time(ring_ssp, tmp_path / "x.ssp", b'value="0.0005"')
    assert read_ssp(path).instance("b").parameters["Ts"] == 0.0005


def test_factor_and_offset_of_both_units_count() -> None:
    """68 degrees Fahrenheit are 20 degrees Celsius."""
    fahrenheit = {"K": "1", "factor": str(5 / 9), "offset": str(273.15 - 32 * 5 / 9)}
    celsius = {"K": "1", "offset": "273.15"}
    setting = Setting("T", 68.0, "degF", {"degF": fahrenheit})
    # three roundings of numbers up to 300
    assert setting.value_in("degC", {"degC": celsius}) == pytest.approx(20.0, abs=1e-12)
