"""The variables that a daemon is started with."""

from __future__ import annotations

import pytest

from lappet.daemon.process import daemon_environment


@pytest.mark.parametrize("machine", ["aarch64", "arm64", "ARM64"])
def test_on_arm_blas_takes_the_kernels_of_every_such_processor(machine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    assert daemon_environment(machine)["OPENBLAS_CORETYPE"] == "ARMV8"


def test_who_names_the_kernels_of_blas_keeps_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENBLAS_CORETYPE", "NEOVERSEN1")
    assert daemon_environment("aarch64")["OPENBLAS_CORETYPE"] == "NEOVERSEN1"


def test_elsewhere_blas_chooses_by_the_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    assert "OPENBLAS_CORETYPE" not in daemon_environment("x86_64")
