#!/usr/bin/env bash
# Compiles the daemon for another system, or for older ones of this, on Debian 12 after packaging/setup.sh:
#
#   bash packaging/cross/build.sh TARGET            the daemon, into build/cross/TARGET/bin with the BLAS that it loads
#   bash packaging/cross/build.sh TARGET --tests    its unit tests too, and runs them (windows-x64 and both of Linux)
#   bash packaging/cross/build.sh TARGET --kernels  the tests of its NEON kernels alone too, and runs them (linux-arm64)
#
# TARGET: windows-x64, linux-x64, linux-arm64, macos-arm64 or macos-x64. Compilers: Debian's mingw-w64 for Windows, for the
# others the clang of the wheel ziglang, which brings the C libraries of Linux and of macOS. libzmq, TBB, CHOLMOD and
# GoogleTest are compiled from Debian's source packages, BLAS is of the wheel scipy-openblas32, headers that need no library
# are those that packaging/setup.sh installed. All is below build/cross, and what is there is not made again.
#
# LAPPET_JOBS says how many compilers run at once, LAPPET_PYTHON which Python has pip and scikit-build-core.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
cd "$here/../.."
cross="$PWD/build/cross"
jobs="${LAPPET_JOBS:-$(nproc)}"
python="${LAPPET_PYTHON:-$PWD/.venv/bin/python}"

say() { printf 'cross build: %s\n' "$*"; }
refuse() {
    printf 'cross build: %s\n' "$*" >&2
    exit 1
}
target="" with_tests=no with_kernels=no
for argument in "$@"; do
    case "$argument" in
        --tests) with_tests=yes ;;
        --kernels) with_kernels=yes ;;
        windows-x64) target="$argument" blas=libscipy_openblas.dll pip_platform=win_amd64 ;;
        linux-x64) target="$argument" blas=libscipy_openblas.so pip_platform=manylinux_2_28_x86_64 ;;
        linux-arm64) target="$argument" blas=libscipy_openblas.so pip_platform=manylinux_2_28_aarch64 ;;
        macos-arm64) target="$argument" blas=libscipy_openblas.dylib pip_platform=macosx_12_0_arm64 ;;
        macos-x64) target="$argument" blas=libscipy_openblas.dylib pip_platform=macosx_12_0_x86_64 ;;
        *) refuse "unknown argument '$argument'; there are windows-x64, linux-x64, linux-arm64, macos-arm64, macos-x64," \
            "--tests and --kernels." ;;
    esac
done
[ -n "$target" ] || refuse "name the target: windows-x64, linux-x64, linux-arm64, macos-arm64 or macos-x64."
case "$target" in
    macos-*) [ "$with_tests" = no ] || refuse "the tests for $target run on such a machine only; leave out --tests." ;;
esac
[ "$with_kernels" = no ] || [ "$target" = linux-arm64 ] || refuse "--kernels is of linux-arm64 only; leave it out."
work="$cross/$target"
prefix="$work/prefix"
mkdir -p "$prefix/lib"

# ---- 1. Debian's packages, sources and headers --------------------------------------------------------------------

# install_packages WORD...: those lines of packages.txt whose first word is one of these.
install_packages() {
    local missing=() name
    for name in $(for word in "$@"; do sed -n -e 's/#.*//' -e "s/^$word: *//p" "$here/packages.txt"; done); do
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
    local apt="$cross/apt"
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    local key=/usr/share/keyrings/debian-archive-keyring.gpg suite
    for suite in debian:bookworm debian-security:bookworm-security; do
        echo "deb-src [signed-by=$key] http://deb.debian.org/${suite%%:*} ${suite##*:} main"
    done >"$apt/sources.list"
    apt-get -q -o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=- -o Dir::State::lists="$apt/lists" \
        -o Dir::Cache="$apt/cache" -o APT::Sandbox::User="$(id -un)" -o Acquire::Retries=3 "$@"
}

source_of() { find "$cross/sources" -mindepth 1 -maxdepth 1 -type d -name "$1-*" | head -n 1; }

# The versions of sources.txt. A package's .dsc has the hashes of its other files, which apt and dpkg-source compare.
fetch_sources() {
    local name version digest described missing=()
    mkdir -p "$cross/sources"
    while read -r name version digest; do
        [ -n "$(source_of "$name")" ] || missing+=("$name=$version")
    done < <(sed -e 's/#.*//' -e '/^ *$/d' "$here/sources.txt")
    [ "${#missing[@]}" -eq 0 ] && return
    say "fetching the sources of ${missing[*]}"
    apt_sources update
    (cd "$cross/sources" && apt_sources source --download-only "${missing[@]}")
    while read -r name version digest; do
        described="$cross/sources/${name}_${version#*:}.dsc"
        echo "$digest  $described" | sha256sum --check --quiet ||
            refuse "$described is not the file whose hash packaging/cross/sources.txt has; see there."
        [ -n "$(source_of "$name")" ] || (cd "$cross/sources" && dpkg-source --extract "$described")
    done < <(sed -e 's/#.*//' -e '/^ *$/d' "$here/sources.txt")
}

# Headers that need no library, without the rest of /usr/include.
link_headers() {
    local name
    mkdir -p "$cross/headers"
    for name in boost CLI fmt msgpack msgpack.hpp spdlog xsimd zmq.hpp; do
        [ -e "/usr/include/$name" ] || refuse "/usr/include/$name is missing; run packaging/setup.sh first."
        ln -sfn "/usr/include/$name" "$cross/headers/$name"
    done
}

# ---- 2. the compiler and BLAS ---------------------------------------------------------------------------------------

# fetch_wheel NAME FOLDER OPTION...: the files of a wheel, of which NAME.txt has the version and the hashes.
fetch_wheel() {
    local name="$1" folder="$2" download
    shift 2
    [ -d "$folder" ] && return
    say "fetching $name"
    download="$(mktemp -d "$cross/download.XXXXXX")"
    "$python" -m pip download --quiet --disable-pip-version-check --no-deps --only-binary=:all: "$@" \
        --dest "$download" --require-hashes --requirement "$here/$name.txt" || refuse "pip could not download $name."
    unzip -qo "$download"/*.whl -d "$download/files"
    mv "$download/files" "$folder"
    rm -r "$download"
}

# Names under which CMake finds the parts of Zig's compiler.
make_tools() {
    local tool
    fetch_wheel ziglang "$cross/ziglang"
    chmod +x "$cross/ziglang/ziglang/zig"
    mkdir -p "$cross/tools"
    for tool in cc c++ ar ranlib; do
        printf '#!/bin/sh\nexport ZIG_GLOBAL_CACHE_DIR="%s" ZIG_LOCAL_CACHE_DIR="%s"\nexec "%s" %s "$@"\n' \
            "$cross/zig-cache" "$cross/zig-cache" "$cross/ziglang/ziglang/zig" "$tool" >"$cross/tools/$tool.new"
        chmod +x "$cross/tools/$tool.new"
        cmp -s "$cross/tools/$tool.new" "$cross/tools/$tool" || mv "$cross/tools/$tool.new" "$cross/tools/$tool"
    done
}

fetch_openblas() {
    fetch_wheel openblas "$work/openblas" --platform "$pip_platform"
    mkdir -p "$work/bin"
    cp -u "$work/openblas/scipy_openblas32/lib/$blas" "$work/bin/"
    if [ "$target" != windows-x64 ]; then
        ln -sfn "../../bin/$blas" "$prefix/lib/$blas" # a folder that is moved keeps it
        return
    fi
    [ -f "$prefix/lib/$blas.a" ] && return
    {
        echo "LIBRARY $blas"
        echo EXPORTS
        printf 'scipy_%s_\n' dtrsv dgemv dtrsm dgemm dsyrk dger dscal dpotrf ztrsv zgemv ztrsm zgemm zherk zgeru zscal zpotrf
    } >"$work/openblas/exports.def"
    # by a name without a folder, since symbols are called after it
    (cd "$prefix/lib" && x86_64-w64-mingw32-dlltool --def "$work/openblas/exports.def" --output-lib "$blas.a")
}

# ---- 3. libraries -------------------------------------------------------------------------------------------------

# library NAME FILE SOURCE OPTION...: configures, builds and installs one, unless FILE is in the prefix.
library() {
    local name="$1" made="$prefix/$2" source="$3"
    shift 3
    [ -f "$made" ] && return
    say "compiling $name"
    cmake -G Ninja -S "$source" -B "$work/libraries/$name" --toolchain "$work/toolchain.cmake" \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_INSTALL_LIBDIR=lib -DBUILD_SHARED_LIBS=OFF \
        -DCMAKE_POLICY_DEFAULT_CMP0074=NEW "$@" >"$work/$name.log" 2>&1 &&
        cmake --build "$work/libraries/$name" --parallel "$jobs" --target install >>"$work/$name.log" 2>&1 ||
        refuse "$name does not compile; see build/cross/$target/$name.log."
}

libraries() {
    # C++20: libzmq's own allocator is not one by the rules of libc++ with an older C++.
    local tbb=libtbb.a zmq=(-DCMAKE_CXX_STANDARD=20)
    case "$target" in
        # `select` waits for few sockets as well as `epoll` does, and needs nothing of the kernel. Of sockets with a path the
        # sources know Microsoft's compiler only: addresses are of TCP.
        windows-*) tbb=libtbb12.a zmq=(-DPOLLER=select -DZMQ_HAVE_IPC=0 -DZMQ_WIN32_WINNT=0x0A00) ;;
        linux-*) zmq+=(-DPOLLER=epoll) ;;
        macos-*) zmq+=(-DPOLLER=kqueue) ;;
    esac
    library suitesparse lib/libcholmod.a "$here/suitesparse" -DSUITESPARSE="$(source_of suitesparse)"
    library libzmq lib/libzmq.a "$(source_of zeromq3)" -DBUILD_SHARED=OFF -DBUILD_TESTS=OFF -DWITH_LIBSODIUM=OFF \
        -DWITH_LIBBSD=OFF -DENABLE_CURVE=ON -DWITH_PERF_TOOL=OFF -DWITH_DOCS=OFF -DENABLE_CPACK=OFF \
        -DENABLE_PRECOMPILED=OFF -DENABLE_WS=OFF -DENABLE_DRAFTS=OFF -DWITH_TLS=OFF "${zmq[@]}"
    library tbb "lib/$tbb" "$(source_of onetbb)" -DTBB_TEST=OFF -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF \
        -DTBB_ENABLE_IPO=OFF -DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON
    [ "$with_tests" = no ] ||
        library googletest lib/libgtest.a "$(source_of googletest)" -DBUILD_GMOCK=OFF -Dgtest_disable_pthreads=OFF
}

# ---- 4. the daemon ------------------------------------------------------------------------------------------------

daemon() {
    local targets=(lappet-solverd) build="$work/daemon" options=(-DLAPPET_BUILD_TESTS=OFF)
    if [ "$with_tests" = yes ]; then
        options=(-DLAPPET_BUILD_TESTS=ON)
        targets+=(solverd_tests)
    fi
    [ "$with_kernels" = no ] || targets+=(neon_twins)
    # Warnings are errors where the checkout is built; those of another compiler are not.
    cmake -G Ninja -S . -B "$build" --toolchain "$work/toolchain.cmake" -DCMAKE_BUILD_TYPE=Release \
        -DLAPPET_WARNINGS_AS_ERRORS=OFF -DLAPPET_BUILD_BENCHMARKS=OFF "${options[@]}" >"$work/daemon.log" ||
        refuse "cmake failed; see build/cross/$target/daemon.log."
    cmake --build "$build" --parallel "$jobs" --target "${targets[@]}"
    if [ "$target" = windows-x64 ]; then
        # with the time that the linker wrote, which is none: two builds are the same
        x86_64-w64-mingw32-strip --preserve-dates -o "$work/bin/lappet-solverd.exe" "$build/solverd/lappet-solverd.exe"
    else  # the linker left the symbols out
        cp "$build/solverd/lappet-solverd" "$work/bin/"
    fi
    say "build/cross/$target/bin is ready."
}

unit_tests() {
    export WINEPREFIX="$cross/wine" WINEDEBUG=-all WINEPATH="$work/bin" LD_LIBRARY_PATH="$work/bin"
    [ "$target" != linux-arm64 ] || export OPENBLAS_CORETYPE=ARMV8  # as Lappet starts the daemon there
    (cd "$work/daemon" && ctest --output-on-failure --parallel "$jobs")
}

kernel_tests() {
    command -v qemu-aarch64 >/dev/null || refuse "qemu-aarch64 is missing; install the package qemu-user."
    say "running the tests of the NEON kernels under qemu"
    OPENBLAS_CORETYPE=ARMV8 LD_LIBRARY_PATH="$work/bin" qemu-aarch64 -cpu cortex-a72 -L /usr/aarch64-linux-gnu \
        "$work/daemon/solverd/neon_twins"
}

case "$target" in
    windows-x64) install_packages all windows ;;
    *) install_packages all ;;
esac
fetch_sources
link_headers
[ "$target" = windows-x64 ] || make_tools
fetch_openblas
printf 'set(LAPPET_TARGET %s)\ninclude("%s/toolchain.cmake")\n' "$target" "$here" >"$work/toolchain.cmake"
libraries
daemon
[ "$with_tests" = no ] || unit_tests
[ "$with_kernels" = no ] || kernel_tests
