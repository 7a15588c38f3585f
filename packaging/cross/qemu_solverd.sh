#!/usr/bin/env bash
# Runs the daemon for Linux on ARM under qemu, where Lappet starts one: LAPPET_SOLVERD=packaging/cross/qemu_solverd.sh.
# LAPPET_QEMU_CPU names the processor (cortex-a72, one with NEON and without SVE), as `qemu-aarch64 -cpu help` lists them.
set -euo pipefail
export OPENBLAS_CORETYPE="${OPENBLAS_CORETYPE:-ARMV8}"  # as Lappet starts it on ARM
build="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/cross"
exec qemu-aarch64 -cpu "${LAPPET_QEMU_CPU:-cortex-a72}" -L /usr/aarch64-linux-gnu \
    "${LAPPET_ARM_SOLVERD:-$build/linux-arm64/bin/lappet-solverd}" "$@"
