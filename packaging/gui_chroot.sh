#!/usr/bin/env bash
# A Debian sid in build/gui/sid with a Blender 5 that opens windows (Debian 12's is 3.4), for `make test-gui`.
#
#   bash packaging/gui_chroot.sh                    make it, once: some minutes, 1.5 GB
#   bash packaging/gui_chroot.sh run COMMAND ...    run COMMAND in it, with this checkout at /lappet
#   bash packaging/gui_chroot.sh remove             delete it
#
# Needs root, or sudo that does not ask. The mounts and the processes of a run live in namespaces of their own, so both
# are gone when it ends, however it ends. LAPPET_DEBIAN_MIRROR names another mirror than deb.debian.org.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
gui="$root/build/gui"
sid="$gui/sid"
mirror="${LAPPET_DEBIAN_MIRROR:-http://deb.debian.org/debian}"
# A window needs a screen and OpenGL; `import` of ImageMagick takes pictures of the screen. Blender's own Python needs
# cattrs, numpy and requests; zmq, msgpack and the rest come from the extension's zip.
packages=(blender imagemagick libegl1 libgl1 libgl1-mesa-dri python3-cattr python3-numpy python3-requests xvfb)

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

# Runs a command in the chroot, in namespaces of its own.
inside() {
    "${as_root[@]}" unshare --mount --propagation private --pid --fork --kill-child \
        bash -c '
            set -e
            sid="$1" checkout="$2"
            shift 2
            mount -t proc proc "$sid/proc"
            mount --bind /dev "$sid/dev"
            mkdir -p "$sid/lappet"
            mount --bind "$checkout" "$sid/lappet"
            exec chroot "$sid" "$@"' inside "$sid" "$root" "$@"
}

make_chroot() {
    local stamp
    stamp="$(sha256sum "${BASH_SOURCE[0]}" | cut -d' ' -f1)"
    [ "$(cat "$gui/made.sha256" 2>/dev/null)" = "$stamp" ] && return
    mkdir -p "$gui"
    if ! command -v debootstrap >/dev/null; then
        say "installing debootstrap"
        local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300)
        { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends debootstrap; } ||
            refuse "apt-get could not install debootstrap; see its message above."
    fi
    if [ ! -e "$gui/bootstrapped" ]; then
        say "making a Debian sid in $sid from $mirror"
        "${as_root[@]}" rm -rf "$sid"
        "${as_root[@]}" debootstrap --variant=minbase sid "$sid" "$mirror" >"$gui/debootstrap.log" 2>&1 || {
            tail -n 5 "$gui/debootstrap.log" >&2
            refuse "debootstrap failed; its log is $gui/debootstrap.log."
        }
        touch "$gui/bootstrapped"
    fi
    say "installing ${packages[*]} in it"
    # A mirror may lag behind the date until which sid's list is called valid; its signature is checked all the same.
    inside env DEBIAN_FRONTEND=noninteractive bash -c '
        apt=(apt-get -q -y -o Acquire::Retries=3 -o Acquire::Check-Valid-Until=false)
        ln -sf /proc/self/mounts /etc/mtab
        "${apt[@]}" update && "${apt[@]}" install --no-install-recommends "$@" && apt-get clean' \
        install "${packages[@]}" >"$gui/install.log" 2>&1 || {
        tail -n 5 "$gui/install.log" >&2
        refuse "apt-get failed in the chroot; its log is $gui/install.log."
    }
    echo "$stamp" >"$gui/made.sha256"
    say "ready: $(inside blender --version 2>/dev/null | head -n 1)"
}

case "${1:-make}" in
    make) make_chroot ;;
    run)
        [ -e "$gui/made.sha256" ] || refuse "there is no chroot yet; run: bash packaging/gui_chroot.sh"
        shift
        inside env -i PATH=/usr/local/bin:/usr/bin:/bin HOME=/root LANG=C.UTF-8 "$@"
        ;;
    remove) "${as_root[@]}" rm -rf "$gui" ;;
    *) refuse "unknown argument '$1'; there are 'run COMMAND ...' and 'remove', or nothing." ;;
esac
