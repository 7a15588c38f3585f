#!/usr/bin/env bash
# A Debian sid in build/gui/sid with a Blender 5 that opens windows (Debian 12's is 3.4), for `make test-gui`.
#
#   bash packaging/gui_chroot.sh                    make it, once: some minutes, 2 GB
#   bash packaging/gui_chroot.sh run COMMAND ...    run COMMAND in it, with this checkout at /lappet, the caller's
#                                                   DISPLAY and the folder of the X11 sockets
#
# Needs root, or sudo that does not ask. The mounts and processes of a run live in namespaces of their own, so they
# are gone when it ends, however it ends. LAPPET_DEBIAN_MIRROR names another mirror than deb.debian.org.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
gui="$root/build/gui"
sid="$gui/sid"
mirror="${LAPPET_DEBIAN_MIRROR:-http://deb.debian.org/debian}"
host_packages=(debootstrap imagemagick x11-utils xvfb)
# python3-pip installs nothing from the network: it puts the wheels of the extension's zip where Blender finds them.
sid_packages=(blender libegl1 libgl1 libgl1-mesa-dri)

say() { printf 'gui: %s\n' "$*"; }
refuse() {
    printf 'gui: %s\n' "$*" >&2
    exit 1
}

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo --non-interactive)
    command -v sudo >/dev/null && "${as_root[@]}" true 2>/dev/null ||
        refuse "making or entering the chroot needs root or a sudo that does not ask; run it as root."
fi
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)

# Runs a command in the chroot, in namespaces of its own.
inside() {
    "${as_root[@]}" unshare --mount --propagation private --pid --fork --kill-child \
        bash -c '
            set -e
            sid="$1" checkout="$2"
            shift 2
            mount -t proc proc "$sid/proc"
            mount --bind /dev "$sid/dev"
            mkdir -p "$sid/lappet" "$sid/tmp/.X11-unix" /tmp/.X11-unix
            mount --bind "$checkout" "$sid/lappet"
            mount --bind /tmp/.X11-unix "$sid/tmp/.X11-unix"
            exec chroot "$sid" "$@"' inside "$sid" "$root" "$@"
}

make_chroot() {
    local missing=() package
    for package in "${host_packages[@]}"; do
        dpkg-query --show --showformat '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed ||
            missing+=("$package")
    done
    if [ "${#missing[@]}" -gt 0 ]; then
        say "installing ${missing[*]}"
        "${apt[@]}" update || refuse "apt-get update failed; see its message above."
        "${apt[@]}" install --no-install-recommends "${missing[@]}" ||
            refuse "apt-get could not install ${missing[*]}; see its message above."
    fi
    local stamp
    stamp="$(sha256sum "${BASH_SOURCE[0]}" | cut -d' ' -f1)"
    if [ "$(cat "$gui/made.sha256" 2>/dev/null)" = "$stamp" ]; then
        return
    fi
    mkdir -p "$gui"
    if [ ! -e "$gui/bootstrapped" ]; then
        say "making a Debian sid in $sid from $mirror"
        "${as_root[@]}" rm -rf "$sid"
        "${as_root[@]}" debootstrap --variant=minbase sid "$sid" "$mirror" >"$gui/debootstrap.log" 2>&1 || {
            tail -5 "$gui/debootstrap.log" >&2
            refuse "debootstrap failed; its log is $gui/debootstrap.log."
        }
        touch "$gui/bootstrapped"
    fi
    say "installing ${sid_packages[*]} in it"
    inside env DEBIAN_FRONTEND=noninteractive bash -c '
        apt-get -q -y -o Acquire::Retries=3 -o Acquire::Check-Valid-Until=false update &&
        apt-get -q -y -o Acquire::Retries=3 install --no-install-recommends "$@" && apt-get clean' \
        install "${sid_packages[@]}" >"$gui/install.log" 2>&1 || {
        tail -5 "$gui/install.log" >&2
        refuse "apt-get failed in the chroot; its log is $gui/install.log."
    }
    echo "$stamp" >"$gui/made.sha256"
    say "ready: $(inside blender --version 2>/dev/null | head -1)"
}

case "${1:-make}" in
    make) make_chroot ;;
    run)
        [ -e "$gui/made.sha256" ] || refuse "there is no chroot yet; run: bash packaging/gui_chroot.sh"
        shift
        inside env -i PATH=/usr/local/bin:/usr/bin:/bin HOME=/root LANG=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 \
            ${DISPLAY:+DISPLAY="$DISPLAY"} "$@"
        ;;
    *) refuse "unknown argument '$1'; there is 'run COMMAND ...', or nothing." ;;
esac
