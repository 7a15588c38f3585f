#!/usr/bin/env bash
# Runs the daemon under sanitizers: its unit tests, the corpus and mutated messages under the address and the
# undefined-behavior sanitizer, several clients under the thread sanitizer. After packaging/setup.sh. Says what each step
# took, and fails if one of them failed. From nothing it takes about 1 600 s of processors: 1 000 to build with the address
# sanitizer, 430 with the thread sanitizer, 180 to run. solverd/cmake/Sanitize.cmake says what is left out.
#
#   bash packaging/sanitize.sh                    all of it, with 100 000 mutated messages
#   bash packaging/sanitize.sh --messages N       the corpus and N mutated messages only (SEED=1); the result is kept
#   bash packaging/sanitize.sh --build            only builds, beside something else
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
jobs="${LAPPET_JOBS:-$(nproc)}"
# A unit test counts allocations with operators of its own, which free what the nothrow ones of the sanitizer gave.
export ASAN_OPTIONS=allocator_may_return_null=1:alloc_dealloc_mismatch=0 UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS="suppressions=$PWD/solverd/cmake/thread_suppressions.txt halt_on_error=1"
export CCACHE_SLOPPINESS=pch_defines,time_macros  # or it keeps nothing that uses a precompiled header
# Solves of many cells, or many of them, whose numbers are tested: smaller ones run the same code. Without these the tests
# take a minute of a processor, with them several.
large=(
    '*BadStart.*' 'Contact.AStrap*' 'Contact.GivesTheSameBits*' 'Contact.ALongStep*' 'Contact.ForcesAre*'
    'ChangeNeighborhood.A*' 'ChangeNeighborhood.T*' 'ChangeNeighborhood.W*'
    'LocalRelaxation.T*' 'SignedDistance.OfASphere*' 'SignedDistance.IsCutOff*' 'MemoryEstimate.TheSpacingAndTheRatio*'
    'Ground.An*' 'Ground.TissueThatSlides*' 'Ground.Heights*' 'Session.ASutureBetweenTwoHeld*' 'Session.AHookCarriesLoose*'
    'AnchorStencil.ASutureNeeds*' 'CellMaterials.TheLayersOfABall*' 'SlidingThread.ARunning*' 'Loads.ACantilever*'
    'Loads.HalfAModel*' '*BoxStates.*double8'
)
failed=()

step() {
    local name="$1" begin=$SECONDS
    shift
    "$@" || failed+=("$name")
    printf 'sanitize: %s: %d s\n' "$name" "$((SECONDS - begin))"
}
build() {
    local preset="$1"
    shift
    cmake --preset "$preset" -DLAPPET_BUILD_BENCHMARKS=OFF >/dev/null &&
        cmake --build --preset "$preset" --parallel "$jobs" --target "$@"
}
play() {
    build/sanitize/solverd/solverd_fuzz tests/daemon/corpus --jobs "$jobs" --seed "${SEED:-1}" --findings build/findings "$@"
}
# In as many processes as there are jobs: with one for each test most of the time would go into starting them.
unit_tests() {
    local shard processes=() status=0
    for ((shard = 0; shard < jobs; shard++)); do
        GTEST_TOTAL_SHARDS="$jobs" GTEST_SHARD_INDEX="$shard" build/sanitize/solverd/solverd_tests \
            --gtest_filter="-$(IFS=:; echo "${large[*]}")" >"build/sanitize/tests_$shard.log" 2>&1 &
        processes+=($!)
    done
    for ((shard = 0; shard < jobs; shard++)); do
        wait "${processes[$shard]}" && continue
        status=1
        grep -aE '^\[  FAILED' "build/sanitize/tests_$shard.log" || tail -n 60 "build/sanitize/tests_$shard.log"
    done
    grep -ahE '^\[  PASSED' build/sanitize/tests_*.log || true
    return "$status"
}
corpus() {
    LAPPET_SOLVERD=build/sanitize/solverd/lappet-solverd .venv/bin/python -m pytest -q tests/daemon/test_message_corpus.py
}
clients() {
    LAPPET_SOLVERD=build/thread/solverd/lappet-solverd PYTHONPATH=tests \
        .venv/bin/python tests/several_clients.py --clients 4 --frames 40
}

if [ "${1:-}" = --messages ]; then
    build sanitize solverd_fuzz
    status=0
    play --messages "$2" --result docs/robustness_fuzz.json || status=$?
    .venv/bin/python packaging/documents.py --write >/dev/null  # docs/robustness.md shows it
    exit "$status"
fi
with_address() { build sanitize lappet-solverd solverd_tests solverd_fuzz; }
with_threads() { build thread lappet-solverd; }
if [ "${1:-}" = --build ]; then
    with_address
    with_threads
    exit
fi
step "build with the address sanitizer" with_address
step "unit tests" unit_tests
step "mutated messages" play --messages 100000
step "the corpus against a daemon" corpus
step "build with the thread sanitizer" with_threads
step "several clients" clients
if [ "${#failed[@]}" -gt 0 ]; then
    printf 'sanitize: failed: %s\n' "$(IFS=,; echo "${failed[*]}")" >&2
    exit 1
fi
printf 'sanitize: clean, %d s\n' "$SECONDS"
