#!/usr/bin/env bash
# Runs the daemon for Windows under wine, where Lappet starts one: LAPPET_SOLVERD=packaging/cross/wine_solverd.sh.
# Sockets in folders and the numbers of Linux's processes are nothing to it: it listens on loopback, with the token, and
# ends with its standard input.
set -euo pipefail
build="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/build/cross"
arguments=()
while [ $# -gt 0 ]; do
    case "$1 ${2:-}" in
        "--address ipc://"* | "--parent "*) shift ;;
        *) arguments+=("$1") ;;
    esac
    shift
done
export WINEPREFIX="${WINEPREFIX:-$build/wine}" WINEDEBUG="${WINEDEBUG:--all}"
exec "${LAPPET_WINE:-wine}" "${LAPPET_WINDOWS_SOLVERD:-$build/windows-x64/bin/lappet-solverd.exe}" "${arguments[@]}"
