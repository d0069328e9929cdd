#!/usr/bin/env bash
# Builds the FMU's binary for every platform that an archive can hold, into FOLDER/<platform>/:
#
#     fmu-src/platforms.sh [FOLDER]              # default: target/platforms
#     stickslip pack --binaries target/platforms
#
# linux64        this project's Rust, linked by zig (pip: cargo-zigbuild, ziglang) against glibc 2.17
# aarch64-linux  the same glibc; the standard library from Debian's rustc-web for arm64
# win64          Debian's rustc-web, which has the sources of the standard library, and mingw-w64
#
# What Debian provides (bookworm with its security updates):
#     apt install rustc-web cargo-web libstd-rust-web-dev rust-web-src gcc-mingw-w64-x86-64-win32
#
# A platform whose tools are missing is left out, with a word on stderr; the exit code is then 3. ONLY="win64" builds
# some platforms only.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-target/platforms}
only=${ONLY:-linux64 aarch64-linux win64}
work=target/platforms-build
left_out=0
mkdir -p "$folder" "$work"

wanted() { case " $only " in *" $1 "*) return 0 ;; *) return 1 ;; esac; }
leave_out() { echo "$1 left out: $2" >&2; left_out=3; }
# Beside the target first, then renamed: an interrupted build leaves no half file.
place() { mkdir -p "$folder/$1"; cp "$2" "$folder/$1/.new"; mv "$folder/$1/.new" "$folder/$1/$3"; echo "$folder/$1/$3"; }

# zig and cargo-zigbuild in an environment of their own.
zig_environment() {
    [ -x "$work/venv/bin/cargo-zigbuild" ] && return
    python3 -m venv "$work/venv"
    "$work/venv/bin/pip" install --quiet --disable-pip-version-check cargo-zigbuild==0.20.1 ziglang==0.13.0.post1
}
zigbuild() { # target, further arguments
    local target=$1
    shift
    PATH="$PWD/$work/venv/bin:$PATH" "$@" cargo-zigbuild zigbuild --release --locked -p beam-fmu \
        --target "$target.2.17" --target-dir "$work/cargo"
}

if wanted linux64; then
    zig_environment
    zigbuild x86_64-unknown-linux-gnu env
    place linux64 "$work/cargo/x86_64-unknown-linux-gnu/release/libbeam_fmu.so" libbeam_fmu.so
fi

debian_rust=/usr/bin/rustc
if wanted aarch64-linux; then
    arm_std=$work/arm64/usr/lib/rustlib/aarch64-unknown-linux-gnu
    if ! command -v apt-get >/dev/null || ! [ -x $debian_rust ]; then
        leave_out aarch64-linux "needs Debian's rustc-web and apt"
    else
        if ! [ -d "$arm_std" ]; then
            # The standard library of the other architecture, unpacked beside; the system's package lists stay as they are.
            state=$PWD/$work/apt
            mkdir -p "$state/lists/partial" "$state/archives/partial" "$work/arm64"
            touch "$state/status"
            apt=(apt-get -o Dir::State="$state" -o Dir::State::status="$state/status" -o Dir::State::lists="$state/lists"
                -o Dir::Cache="$state" -o APT::Architecture=arm64 -o APT::Architectures=arm64)
            "${apt[@]}" -qq update
            (cd "$state" && "${apt[@]}" -qq download libstd-rust-web-dev)
            dpkg-deb -x "$state"/libstd-rust-web-dev_*_arm64.deb "$work/arm64"
        fi
        zig_environment
        # A root of the compiler that has the libraries of both architectures.
        root=$PWD/$work/sysroot/lib/rustlib
        mkdir -p "$root"
        ln -sfn "$PWD/$arm_std" "$root/aarch64-unknown-linux-gnu"
        ln -sfn "$(rustc_root=$($debian_rust --print sysroot); echo "$rustc_root/lib/rustlib/x86_64-unknown-linux-gnu")" \
            "$root/x86_64-unknown-linux-gnu"
        zigbuild aarch64-unknown-linux-gnu env RUSTC=$debian_rust RUSTFLAGS="--sysroot $PWD/$work/sysroot"
        place aarch64-linux "$work/cargo/aarch64-unknown-linux-gnu/release/libbeam_fmu.so" libbeam_fmu.so
    fi
fi

if wanted win64; then
    linker=x86_64-w64-mingw32-gcc-win32
    if ! command -v $linker >/dev/null || ! [ -x $debian_rust ]; then
        leave_out win64 "needs Debian's rustc-web, rust-web-src and mingw-w64"
    else
        # Debian's compiler has no standard library for Windows, but its sources: cargo builds it along.
        RUSTC_BOOTSTRAP=1 RUSTC=$debian_rust CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=$linker \
            /usr/bin/cargo build --release --locked -p beam-fmu --target x86_64-pc-windows-gnu \
            -Zbuild-std=std,panic_unwind --target-dir "$work/cargo"
        # `pack` strips ELF files itself; the library with its line tables stays in the build folder.
        x86_64-w64-mingw32-strip -o "$work/beam_fmu.dll" "$work/cargo/x86_64-pc-windows-gnu/release/beam_fmu.dll"
        place win64 "$work/beam_fmu.dll" beam_fmu.dll
    fi
fi
exit $left_out
