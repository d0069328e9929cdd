#!/usr/bin/env bash
# Random calls (tests/fmi_fuzz.rs) under valgrind: fails on a leak, on a read of memory that was not written, and on an
# access outside of what is allocated. Results: docs/fuzzing.md.
#
#     FUZZ_CALLS=30000 tests/valgrind.sh         # about 100 times slower than without
set -euo pipefail
cd "$(dirname "$0")/.."
binary=$(cargo test --release --test fmi_fuzz --no-run --message-format=json |
    sed -n 's/.*"name":"fmi_fuzz".*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)
# Valgrind keeps freed blocks for a while, so the process's size says nothing.
FUZZ_CALLS=${FUZZ_CALLS:-3000} FUZZ_MEMORY=ignore valgrind --leak-check=full \
    --show-leak-kinds=definite,indirect --errors-for-leak-kinds=definite,indirect --error-exitcode=9 \
    "$binary" --test-threads=1 --nocapture
