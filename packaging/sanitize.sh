#!/usr/bin/env bash
# Runs the daemon under sanitizers: its unit tests, the corpus and mutated messages under the address and the
# undefined-behavior sanitizer, several clients under the thread sanitizer. After packaging/setup.sh.
#
#   bash packaging/sanitize.sh                    all of it, with 100 000 mutated messages
#   bash packaging/sanitize.sh --messages N       the corpus and N mutated messages only (SEED=1)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
jobs="${LAPPET_JOBS:-$(nproc)}"
messages=100000
only_messages=
if [ "${1:-}" = --messages ]; then
    messages="$2"
    only_messages=1
fi
# A unit test counts allocations with operators of its own, which free what the nothrow ones of the sanitizer gave.
export ASAN_OPTIONS=allocator_may_return_null=1:alloc_dealloc_mismatch=0 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/solverd/cmake/thread_suppressions.txt halt_on_error=1"

build() {
    local preset="$1"
    shift
    cmake --preset "$preset" -DLAPPET_BUILD_BENCHMARKS=OFF >/dev/null
    cmake --build --preset "$preset" --parallel "$jobs" --target "$@"
}
play() {
    build/sanitize/solverd/solverd_fuzz tests/daemon/corpus --messages "$messages" --seed "${SEED:-1}" --jobs "$jobs" \
        --findings build/findings
}

if [ -n "$only_messages" ]; then
    build sanitize solverd_fuzz
    play
    exit
fi
build sanitize lappet-solverd solverd_tests solverd_fuzz
build thread lappet-solverd
status=0
ctest --preset sanitize --parallel "$jobs" --no-tests=error || status=1
play || status=1
LAPPET_SOLVERD=build/sanitize/solverd/lappet-solverd .venv/bin/python -m pytest -q tests/daemon/test_message_corpus.py ||
    status=1
LAPPET_SOLVERD=build/thread/solverd/lappet-solverd PYTHONPATH=tests \
    .venv/bin/python tests/several_clients.py --clients 4 --frames 40 || status=1
exit "$status"
