"""What things cost: `python -m lappet.bench`, which `make bench` runs in a source checkout.

`kernels` has the daemon's kernels measured by solverd_benchmarks and says how close to the machine's limits they are;
`scenes` solves whole examples; `sheets` solves the plain problems that other programs publish figures for. `tables`
writes all of it as JSON, CSV and Markdown, beside the figures of `published.toml`.
"""
