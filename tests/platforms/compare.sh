#!/usr/bin/env bash
# Runs the binaries that fmu-src/platforms.sh has built, each on its platform or an emulator of it, and compares their
# motions to the bit with that of linux64. Says what it could not run; fails where a motion differs.
#
#     tests/platforms/compare.sh [FOLDER]        # default: target/platforms
#
# Debian: apt install gcc gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static gcc-mingw-w64-x86-64-win32 wine wine64
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=${1:-target/platforms}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
source=tests/platforms/motion.c
guid=$(sed -n 's/.* guid="\([^"]*\)".*/\1/p' modelDescription/modelDescription.xml | head -n 1)
# tip_displacement, tip_velocity, friction_force: value references of modelDescription.xml.
references=(10 11 13)

gcc -O1 -o "$work/native" $source -ldl
"$work/native" "$folder/linux64/libbeam_fmu.so" "$guid" "${references[@]}" >"$work/linux64.txt"
echo "linux64: $(wc -l <"$work/linux64.txt") lines; needs $(objdump -T "$folder/linux64/libbeam_fmu.so" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -n 1)"

failed=0
largest_difference() { # two lists of numbers, platform; fails where it is more than rounding
    python3 - "$@" <<'PYTHON'
import sys

ours, theirs = ([[float.fromhex(v) for v in line.split()] for line in open(name)] for name in sys.argv[1:3])
columns = list(zip(zip(*ours), zip(*theirs)))
most = max(max(abs(a - b) for a, b in zip(x, y)) / max(map(abs, x)) for x, y in columns)
print(f"{sys.argv[3]}: differs by at most {most:.1e} of the largest value in its column")
sys.exit(not most < 1e-12)
PYTHON
}
compare() { # platform
    tr -d '\r' <"$work/$1.txt" | sed 's/0x\([0-9a-f.]*\)p/0x\1p/g' >"$work/$1.clean"
    if cmp -s "$work/linux64.txt" "$work/$1.clean"; then
        echo "$1: the same to the bit"
    else
        # The C libraries' exp and cos may differ in the last bit, and a few cycles double that now and then.
        largest_difference "$work/linux64.txt" "$work/$1.clean" "$1" || failed=1
    fi
}

library=$folder/aarch64-linux/libbeam_fmu.so
if [ ! -f "$library" ]; then
    echo "aarch64-linux: not built"
elif ! command -v qemu-aarch64-static >/dev/null || ! command -v aarch64-linux-gnu-gcc >/dev/null; then
    echo "aarch64-linux: not run, there is no qemu-aarch64-static or no aarch64-linux-gnu-gcc"
else
    aarch64-linux-gnu-gcc -O1 -o "$work/arm" $source -ldl
    qemu-aarch64-static -L /usr/aarch64-linux-gnu "$work/arm" "$library" "$guid" "${references[@]}" >"$work/aarch64-linux.txt"
    compare aarch64-linux
fi

library=$folder/win64/beam_fmu.dll
if [ ! -f "$library" ]; then
    echo "win64: not built"
elif ! command -v wine >/dev/null || ! command -v x86_64-w64-mingw32-gcc-win32 >/dev/null; then
    echo "win64: not run, there is no wine or no x86_64-w64-mingw32-gcc-win32"
else
    # The C99 formats of mingw-w64, so that %a is written as elsewhere.
    x86_64-w64-mingw32-gcc-win32 -O1 -D__USE_MINGW_ANSI_STDIO=1 -o "$work/motion.exe" $source
    cp "$library" "$work/"
    # Windows has it since version 7, Wine before 9 not: the one function that Rust's library takes from it, for its hash maps.
    x86_64-w64-mingw32-gcc-win32 -shared -o "$work/bcryptprimitives.dll" tests/platforms/process_prng.c -ladvapi32
    WINEPREFIX=$work/wine WINEDEBUG=-all wine "$work/motion.exe" "$work/beam_fmu.dll" "$guid" "${references[@]}" >"$work/win64.txt"
    # Wine goes on for a moment and writes into its folder.
    WINEPREFIX=$work/wine wineserver -w
    compare win64
fi
exit $failed
