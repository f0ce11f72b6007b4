from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipj, ellipkinc

from mitlplan.trajectory.elliptic import Modulus

angles = st.floats(-9.0, 9.0)


def modulus(complement: float) -> Modulus:
    return Modulus(math.sqrt(1 - complement), complement)


@given(angles, st.floats(0.001, 0.999))
def test_argument_and_amplitude_agree_with_scipy(angle: float, complement: float) -> None:
    argument = modulus(complement).argument(angle)
    assert argument == pytest.approx(ellipkinc(angle, 1 - complement), abs=1e-12)
    found, _ = modulus(complement).amplitude(np.array(argument))
    sn, cn, dn, _ = ellipj(argument, 1 - complement)
    assert np.sin(found) == pytest.approx(sn, abs=1e-11)
    assert np.cos(found) == pytest.approx(cn, abs=1e-11)
    assert modulus(complement).delta(found) == pytest.approx(dn, abs=1e-11)


@given(angles, st.integers(1, 60))
def test_amplitude_undoes_argument_however_near_the_modulus_is_to_one(angle: float, power: int) -> None:
    near = modulus(10.0**-power)
    assert float(near.amplitude(np.array(near.argument(angle)))[0]) == pytest.approx(angle, abs=1e-10)


@pytest.mark.parametrize("complement", [1e-30, 1e-6, 0.3, 0.999999])
def test_area_is_the_integral_of_the_squared_sine(complement: float) -> None:
    shape = modulus(complement)

    def square(argument: float) -> float:
        return float(np.sin(shape.amplitude(np.array(argument))[0]) ** 2)

    for argument in (-1.3, 0.4, 3.1):
        expected, _ = quad(square, 0.0, argument, epsabs=1e-12)
        assert float(shape.amplitude(np.array(argument))[1]) == pytest.approx(expected, abs=1e-11)


def test_a_small_modulus_keeps_its_digits() -> None:
    _, area = Modulus(1e-9, 1.0).amplitude(np.array(2.0))
    assert float(area) == pytest.approx(1.0 - math.sin(4.0) / 4, abs=1e-14)
