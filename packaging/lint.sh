#!/usr/bin/env bash
# Every check that needs no run of the program: style, types, import directions, docstrings, lengths of functions,
# documents, known vulnerabilities. Runs them all, then fails if one of them failed. After packaging/setup.sh.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
failed=()

check() {
    local name="$1"
    shift
    printf -- '-- %s\n' "$name"
    "$@" || failed+=("$name")
}

cpp_files() { find solverd -name '*.h' -o -name '*.cpp'; }
clang_format() { cpp_files | xargs -r .venv/bin/clang-format --dry-run --Werror; }

check "ruff check" "$python" -m ruff check --quiet .
check "ruff format" "$python" -m ruff format --quiet --check .
check "mypy" "$python" -m mypy
check "clang-format" clang_format
check "import directions" "$python" packaging/check_imports.py
check "docstrings" "$python" packaging/check_docstrings.py
check "lengths of functions" "$python" packaging/check_lengths.py
check "types of the viewer" "$python" packaging/viewer.py --check
check "documents" "$python" packaging/documents.py --check
check "known vulnerabilities" "$python" packaging/vulnerabilities.py
check "Debian packages" "$python" packaging/system_versions.py   # tells differences, refuses none

if [ "${#failed[@]}" -gt 0 ]; then
    printf 'lint: failed: %s\n' "$(IFS=,; echo "${failed[*]}")" >&2
    exit 1
fi
echo "lint: clean"
