"""Writes docs/robustness.md: how daemon and frames are attacked, with the last results of three campaigns."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/robustness.md"
FUZZ, CHAOS = "docs/robustness_fuzz.json", "docs/robustness_chaos.json"
FOLDINGS = "docs/robustness_foldings.json"

TEXT = """# How daemon and frames are attacked

`make docs` writes this page; the results on it are those of the files that `make fuzz`, `make foldings` and `make
chaos` wrote. [SECURITY.md](../SECURITY.md) says what is promised.

## Messages

[The corpus](../tests/daemon/corpus/README.md) holds every message type and every attack that was found, one file
each. The program `solverd_fuzz` plays it without sockets, message for message, against the decoding and the sessions
of the daemon. Then it mutates its messages: header fields, shapes, counts, numbers, lengths, order. The same seed
gives the same messages. One block of 64 messages in sixteen goes to a session whose epochs and frames are built and
solved; after it the conversation that it came from is played again in a new session and must be answered bit for bit
as before. What ends the program, takes more than 30 s of a processor or breaks the protocol is a finding: its
messages are written to `build/findings`, and become a file of the corpus when it is corrected.

`make fuzz` plays a million messages under the address and the undefined-behavior sanitizer, `MESSAGES` and `SEED`
choose others. The last campaign ([as JSON](robustness_fuzz.json)):

{fuzz}

`make sanitize`, which CI runs, plays 100 000 messages after the daemon's unit tests, both under the same sanitizers,
the corpus against a daemon, and four clients of one daemon under the thread sanitizer.

## Tissue that is folded

`make foldings` cuts one flap or two of any shape into a patch of skin, frees them and folds them with hooks at random
onto themselves, onto each other and into the skin beside them, with
[self-contact](self_contact.md); now and then a thread draws two places together through what lies
between. The [IPC Toolkit](https://ipctk.xyz), which shares nothing with the daemon, looks at the surface of every
frame, also of those in which the solver did not converge: no edge may go through a face. Every tenth folding is solved
without self-contact too, to tell how often there is something to keep apart. `COUNT` and `SEED` choose others; the
tests play five. The last campaign ([as JSON](robustness_foldings.json)):

{foldings}

## Solves that are disturbed

`make chaos` solves a procedure again and again for two minutes while something happens to it, at random with a seed
(`SEED`): daemon or client or both are killed, the daemon or the client is stopped for a while, Ctrl-C comes once or
several times, the disk is full from some byte on, stored frames are cut, or vanish. After each no partial file has a
final name, nothing of the solve runs on and none of its temporary files is left; the next solve gives the cache of a
solve that was never disturbed, bit for bit. The tests do the same for some seconds. The last two minutes ([as
JSON](robustness_chaos.json)):

{chaos}

## Clients of one daemon

`python tests/several_clients.py` has eight clients solve 10 000 frames in one daemon and compares every bit with what
a lone client gets; the tests do it with 800, the thread sanitizer with 40.
"""


def robustness_page() -> str:
    """Return the text of docs/robustness.md."""
    return TEXT.format(fuzz=_fuzz(_read(FUZZ)), foldings=_foldings(_read(FOLDINGS)), chaos=_chaos(_read(CHAOS)))


def _read(name: str) -> dict[str, Any]:
    result: dict[str, Any] = json.loads((ROOT / name).read_text(encoding="utf-8"))
    return result


def _fuzz(result: dict[str, Any]) -> str:
    rows = {
        "day": result["date"],
        "sanitizers": result["sanitizers"] or "none",
        "seed": result["seed"],
        "messages asked for": _number(result["wanted"]),
        "messages played": _number(result["messages"]),
        "seconds": _number(result["seconds"]),
        "findings": result["findings"],
    }
    return _table(rows)


def _foldings(result: dict[str, Any]) -> str:
    ends = ", ".join(f"{count} × {name.replace('_', ' ')}" for name, count in result["ends"].items())
    unconverged = str(sum(result["ends"].values())) + (ends and f": {ends}")
    rows = {
        "day": result["date"],
        "seed": result["seed"],
        "seconds": _number(result["seconds"]),
        "foldings": _number(result["foldings"]),
        "procedures refused, and others played": result["refused"],
        "frames": f"{_number(result['frames'])}, in {_number(result['touching'])} of them tissue presses on tissue",
        "foldings that end in a frame that does not converge": unconverged,
        "frames that pass through themselves": len(result["through"]),
        "the same foldings without self-contact": f"{result['controls_through']} of {result['controls']} pass through",
    }
    return "\n".join([_table(rows), *(f"\n- {sentence}" for sentence in (*result["through"], *result["unexplained"]))])


def _chaos(result: dict[str, Any]) -> str:
    kinds = ", ".join(f"{count} × {name.replace('_', ' ')}" for name, count in result["disturbances"].items())
    rows = {
        "day": result["date"],
        "seed": result["seed"],
        "seconds": result["seconds"],
        "disturbed solves": f"{result['solves']}: {kinds}",
        "broken promises": len(result["broken"]),
    }
    return "\n".join([_table(rows), *(f"\n- {sentence}" for sentence in result["broken"])])


def _table(rows: dict[str, Any]) -> str:
    return "\n".join(["| what | result |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows.items())])


def _number(count: int) -> str:
    return f"{count:,}".replace(",", " ")
