#!/usr/bin/env bash
# Makes a checkout ready on Debian 12: system packages, a Python environment in .venv, the program of lessons in
# build/viewer, the daemon in build/solverd.
# Does only what is missing, so running it again is quick. Never asks a question.
#
#   bash packaging/setup.sh                everything
#   bash packaging/setup.sh --tests        the daemon's tests too, its benchmarks, which the tests run, and the package
#                                          that the body models are cut from
#   bash packaging/setup.sh --benchmarks   its benchmarks
#
# LAPPET_PYTHON names the Python 3.11 to make .venv with; LAPPET_JOBS how many compilers run at once.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
venv="$root/.venv"
build="$root/build"
# What must be there before the rest: pip itself, and what the sources of the lock's packages without a wheel build with.
installers=(pip setuptools wheel numpy)

say() { printf 'setup: %s\n' "$*"; }
refuse() {
    printf 'setup: %s\n' "$*" >&2
    exit 1
}

targets=(lappet-solverd)
with_models=no
for argument in "$@"; do
    case "$argument" in
        --tests) targets+=(solverd_tests solverd_benchmarks) with_models=yes ;;
        --benchmarks) targets+=(solverd_benchmarks) ;;
        *) refuse "unknown argument '$argument'; there are --tests and --benchmarks." ;;
    esac
done

# A link leads into another checkout: its editable package would become this one's, its daemon built from these sources.
for folder in .venv build; do
    [ -L "$folder" ] && refuse "$root/$folder is a link to $(readlink "$folder")." \
        "What is set up here would be installed there. Remove the link (rm $folder), then set up again."
done

# ---- 1. system packages -------------------------------------------------------------------------------------------

wanted_packages() { sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' packaging/system_packages.txt; }

missing_packages() {
    # `dpkg-query` lists only what it knows: what is wanted but not listed as installed is missing.
    comm -23 <(wanted_packages | sort -u) \
        <(dpkg-query --show --showformat '${db:Status-Status} ${Package}\n' 2>/dev/null | sed -n 's/^installed //p' | sort -u)
}

install_system_packages() {
    if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
        say "this is not Debian, so the packages of packaging/system_packages.txt are taken to be there."
        return
    fi
    local missing=()
    mapfile -t missing < <(missing_packages)
    [ "${#missing[@]}" -eq 0 ] && return
    local as_root=()
    if [ "$(id -u)" -ne 0 ]; then
        # At a terminal sudo may ask for the password; elsewhere nothing may ask.
        as_root=(sudo)
        [ -t 0 ] || as_root+=(--non-interactive)
        command -v sudo >/dev/null && "${as_root[@]}" true ||
            refuse "Debian packages are missing (${#missing[@]}) and there is neither root nor sudo to install them." \
                "Ask an administrator for: apt-get install --no-install-recommends ${missing[*]}"
    fi
    say "installing ${#missing[@]} Debian packages: ${missing[*]}"
    local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300
        -o Acquire::Retries=3)
    "${apt[@]}" update || refuse "apt-get update failed; see its message above."
    "${apt[@]}" install --no-install-recommends "${missing[@]}" || refuse "apt-get install failed; see its message above."
}

# ---- 2. Python ----------------------------------------------------------------------------------------------------

is_python_311() {
    "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info[:2] != (3, 11))' >/dev/null 2>&1
}

find_python() {
    local candidate
    for candidate in ${LAPPET_PYTHON:+"$LAPPET_PYTHON"} /usr/bin/python3 python3.11 python3; do
        if is_python_311 "$candidate"; then
            echo "$candidate"
            return
        fi
    done
    refuse "no Python 3.11 found (Blender's module needs exactly 3.11). Name one with LAPPET_PYTHON=/path/to/python3.11."
}

requirements_stamp() {
    { cat pyproject.toml packaging/lock.txt packaging/setup.sh; echo "$root"; "$venv/bin/python" --version; } |
        sha256sum | cut -d' ' -f1
}

without_chatter() {
    grep --line-buffered -vE '^(Requirement already|Collecting|Looking in|Installing collected)' || true
}

install_python() {
    if ! "$venv/bin/python" -c 'import pip, sys; sys.exit(sys.version_info[:2] != (3, 11))' >/dev/null 2>&1; then
        local python
        python="$(find_python)"
        say "making .venv with $python"
        "$python" -m venv --clear "$venv"
    fi
    local stamp_file="$venv/lappet-requirements.sha256" stamp
    stamp="$(requirements_stamp)"
    if [ -x "$venv/bin/lappet" ] && [ "$(cat "$stamp_file" 2>/dev/null)" = "$stamp" ]; then
        return
    fi
    say "installing the Python packages into .venv (the first time 600 MB, most of it Blender's module)"
    # Exactly the files of the lock, by their hashes: pip resolves nothing, and what it builds from sources (what has
    # no wheel) it builds with the locked installers.
    local pip=("$venv/bin/python" -m pip --disable-pip-version-check --no-input)
    local install=("${pip[@]}" install --no-deps --no-build-isolation --progress-bar off --requirement)
    "$venv/bin/python" packaging/locked.py "${installers[@]}" >"$venv/lappet-installers.txt"
    "${install[@]}" "$venv/lappet-installers.txt" | without_chatter ||
        refuse "pip could not install ${installers[*]}; see its message above."
    "${install[@]}" packaging/lock.txt | without_chatter ||
        refuse "pip could not install the Python packages; see its message above."
    # Editable, without the daemon: that one is built below, where a change of a source file rebuilds it.
    "${pip[@]}" install --quiet --no-build-isolation --no-deps --force-reinstall --editable . \
        --config-settings=wheel.cmake=false --config-settings=editable.mode=inplace ||
        refuse "pip could not install lappet itself; see its message above."
    echo "$stamp" >"$stamp_file"
}

# ---- 3. the program of lessons --------------------------------------------------------------------------------------

# Before the daemon: a compiler's error leaves nothing else undone.
build_viewer() {
    local needed=()
    [ "$with_models" = yes ] && needed=(--tests)
    "$venv/bin/python" packaging/viewer.py "${needed[@]}" ||
        refuse "the program of lessons could not be built; see the message above."
}

# ---- 4. the daemon ------------------------------------------------------------------------------------------------

build_daemon() {
    # A build folder that was copied or moved here belongs to another checkout: configure it anew.
    if [ -f "$build/CMakeCache.txt" ] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$build/CMakeCache.txt"; then
        rm -rf "$build/CMakeCache.txt" "$build/CMakeFiles"
    fi
    if [ ! -f "$build/build.ninja" ] || ! grep -qsxF "LAPPET_BUILD_BENCHMARKS:BOOL=ON" "$build/CMakeCache.txt"; then
        say "configuring the daemon"
        cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DLAPPET_BUILD_TESTS=ON \
            -DLAPPET_BUILD_BENCHMARKS=ON >"$build.log" 2>&1 || {
            cat "$build.log" >&2
            refuse "CMake could not configure the daemon; see its message above."
        }
        mkdir -p "$build" && mv "$build.log" "$build/configure.log"
    fi
    cmake --build "$build" --parallel "${LAPPET_JOBS:-$(nproc)}" --target "${targets[@]}" ||
        refuse "the daemon did not compile; see the compiler's message above."
}

# ---- 5. the package of the body models -----------------------------------------------------------------------------

fetch_models() {
    [ "$with_models" = yes ] || return 0
    "$venv/bin/lappet" models fetch >/dev/null ||
        refuse "the package of the body models, which the tests read, could not be fetched; see the message above."
}

install_system_packages
install_python
build_viewer
build_daemon
fetch_models
say "ready: .venv/bin/lappet and build/solverd/lappet-solverd"
