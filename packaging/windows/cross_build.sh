#!/usr/bin/env bash
# Compiles the daemon for Windows on x86-64, on Debian 12: the cross compiler and wine from Debian's packages, libzmq, TBB,
# CHOLMOD and GoogleTest from Debian's source packages, BLAS from the wheel scipy-openblas32. After packaging/setup.sh.
# All of it is below build/windows, and what is there is not made again; build/windows/bin has the daemon and its library.
#
#   bash packaging/windows/cross_build.sh            the daemon
#   bash packaging/windows/cross_build.sh --tests    its unit tests too, and runs them under wine
#
# LAPPET_JOBS says how many compilers run at once, LAPPET_PYTHON which Python has pip and scikit-build-core.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$here/../.."
work="$PWD/build/windows"
jobs="${LAPPET_JOBS:-$(nproc)}"
python="${LAPPET_PYTHON:-$PWD/.venv/bin/python}"
debian_sources=(zeromq3 onetbb suitesparse googletest)
prefix="$work/prefix"

say() { printf 'cross_build: %s\n' "$*"; }
refuse() {
    printf 'cross_build: %s\n' "$*" >&2
    exit 1
}
with_tests=no
for argument in "$@"; do
    case "$argument" in
        --tests) with_tests=yes ;;
        *) refuse "unknown argument '$argument'; there is --tests." ;;
    esac
done

# ---- 1. Debian's packages, sources and headers --------------------------------------------------------------------

install_packages() {
    local missing=() name
    for name in $(sed -e 's/#.*//' "$here/packages.txt"); do
        [ "$(dpkg-query --show --showformat '${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
    done
    [ "${#missing[@]}" -eq 0 ] && return
    local as_root=()
    [ "$(id -u)" -eq 0 ] || as_root=(sudo --non-interactive)
    say "installing ${missing[*]}"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 install \
        --no-install-recommends "${missing[@]}" ||
        refuse "apt-get failed; ask an administrator for: apt-get install --no-install-recommends ${missing[*]}"
}

# apt with a list of sources and folders of its own: the system's stay as they are.
apt_sources() {
    local apt="$work/apt"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    local key=/usr/share/keyrings/debian-archive-keyring.gpg suite
    for suite in debian:bookworm debian-security:bookworm-security; do
        echo "deb-src [signed-by=$key] http://deb.debian.org/${suite%%:*} ${suite##*:} main"
    done >"$apt/sources.list"
    apt-get -q -o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$apt/lists" \
        -o Dir::Cache="$apt/cache" -o APT::Sandbox::User="$(id -un)" -o Acquire::Retries=3 "$@"
}

source_of() { find "$work/sources" -mindepth 1 -maxdepth 1 -type d -name "$1-*" | head -n 1; }

fetch_sources() {
    local name missing=()
    mkdir -p "$work/sources"
    for name in "${debian_sources[@]}"; do
        [ -n "$(source_of "$name")" ] || missing+=("$name")
    done
    [ "${#missing[@]}" -eq 0 ] && return
    say "fetching the sources of ${missing[*]}"
    apt_sources update
    (cd "$work/sources" && apt_sources source "${missing[@]}")
}

# Headers that need no library, without the rest of /usr/include.
link_headers() {
    local name
    mkdir -p "$prefix/headers"
    for name in boost CLI fmt msgpack msgpack.hpp spdlog xsimd zmq.hpp; do
        [ -e "/usr/include/$name" ] || refuse "/usr/include/$name is missing; run packaging/setup.sh first."
        ln -sfn "/usr/include/$name" "$prefix/headers/$name"
    done
}

# ---- 2. BLAS ------------------------------------------------------------------------------------------------------

fetch_openblas() {
    local made="$prefix/lib/libscipy_openblas.dll.a"
    [ -f "$made" ] && return
    mkdir -p "$work/wheels" "$prefix/lib" "$prefix/bin"
    if ! ls "$work/wheels/"*.whl >/dev/null 2>&1; then
        "$python" -m pip download --quiet --no-deps --only-binary=:all: --platform win_amd64 --dest "$work/wheels" \
            --require-hashes --requirement "$here/openblas.txt"
    fi
    unzip -qo "$work/wheels/"scipy_openblas32-*.whl -d "$work/openblas"
    local dll="$work/openblas/scipy_openblas32/lib/libscipy_openblas.dll" definitions="$work/openblas/exports.def"
    {
        echo "LIBRARY libscipy_openblas.dll"
        echo EXPORTS
        printf 'scipy_%s_\n' dtrsv dgemv dtrsm dgemm dsyrk dger dscal dpotrf ztrsv zgemv ztrsm zgemm zherk zgeru zscal zpotrf
    } >"$definitions"
    x86_64-w64-mingw32-dlltool --def "$definitions" --output-lib "$made.new"
    cp "$dll" "$prefix/bin/"
    mv "$made.new" "$made"
}

# ---- 3. libraries -------------------------------------------------------------------------------------------------

# library NAME FILE SOURCE OPTION...: configures, builds and installs one, unless FILE is in the prefix.
library() {
    local name="$1" made="$prefix/$2" source="$3"
    shift 3
    [ -f "$made" ] && return
    say "compiling $name"
    cmake -G Ninja -S "$source" -B "$work/libraries/$name" --toolchain "$here/toolchain.cmake" \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DBUILD_SHARED_LIBS=OFF \
        -DCMAKE_POLICY_DEFAULT_CMP0074=NEW "$@" >"$work/$name.log" 2>&1 &&
        cmake --build "$work/libraries/$name" --parallel "$jobs" --target install >>"$work/$name.log" 2>&1 ||
        refuse "$name does not compile; see build/windows/$name.log."
}

libraries() {
    library suitesparse lib/libcholmod.a "$here/suitesparse" -DSUITESPARSE="$(source_of suitesparse)"
    # `select` waits for few sockets as well as `epoll` does, and needs nothing of the kernel. Of sockets with a path the
    # sources know Microsoft's compiler only: addresses are of TCP.
    library libzmq lib/libzmq.a "$(source_of zeromq3)" -DBUILD_SHARED=OFF -DBUILD_TESTS=OFF -DWITH_LIBSODIUM=OFF \
        -DENABLE_CURVE=ON -DWITH_PERF_TOOL=OFF -DWITH_DOCS=OFF -DENABLE_CPACK=OFF -DENABLE_PRECOMPILED=OFF \
        -DPOLLER=select -DZMQ_HAVE_IPC=0 -DZMQ_WIN32_WINNT=0x0A00 -DENABLE_WS=OFF -DENABLE_DRAFTS=OFF -DWITH_TLS=OFF
    library tbb lib/libtbb12.a "$(source_of onetbb)" -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF \
        -DTBB_ENABLE_IPO=OFF -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON
    library googletest lib/libgtest.a "$(source_of googletest)" -DBUILD_GMOCK=OFF -Dgtest_disable_pthreads=OFF
}

# ---- 4. the daemon ------------------------------------------------------------------------------------------------

daemon() {
    local targets=(lappet-solverd) build="$work/daemon"
    [ "$with_tests" = no ] || targets+=(solverd_tests)
    cmake -G Ninja -S . -B "$build" --toolchain "$here/toolchain.cmake" -DCMAKE_BUILD_TYPE=Release \
        -DLAPPET_BUILD_BENCHMARKS=OFF >"$work/daemon.log" || refuse "cmake failed; see build/windows/daemon.log."
    cmake --build "$build" --parallel "$jobs" --target "${targets[@]}"
    mkdir -p "$work/bin"
    cp -u "$prefix/bin/libscipy_openblas.dll" "$work/bin/"
    x86_64-w64-mingw32-strip -o "$work/bin/lappet-solverd.exe" "$build/solverd/lappet-solverd.exe"
    say "build/windows/bin/lappet-solverd.exe"
}

unit_tests() {
    export WINEPREFIX="$work/wine" WINEDEBUG=-all WINEPATH="$work/bin"
    (cd "$work/daemon" && ctest --output-on-failure --parallel "$jobs")
}

install_packages
fetch_sources
link_headers
fetch_openblas
libraries
daemon
[ "$with_tests" = no ] || unit_tests
