"""The check of the kernels' symbols finds what an old processor would crash on."""

from __future__ import annotations

from check_kernel_symbols import instruction_set, shared_symbols

OWN = """\
0000000000001370 T lappet::fill_elastic_kernels_avx2(lappet::SceneFeatures const&, lappet::ElasticKernels<float>&)
0000000000000000 V DW.ref.__gxx_personality_v0
0000000000000000 W void lappet::svd3<xsimd::batch<float, xsimd::fma3<xsimd::avx2> > >(float const (&) [9])
0000000000000040 t lappet::(anonymous namespace)::local(int)
"""


def test_a_unit_of_templates_on_its_batch_passes() -> None:
    assert shared_symbols(OWN, "avx2") == []


def test_shared_functions_in_a_kernel_unit_are_found() -> None:
    vector = "std::vector<int, std::allocator<int> >::resize(unsigned long)"
    narrow = "xsimd::batch<float, xsimd::sse4_2> lappet::half<xsimd::batch<float, xsimd::sse4_2> >()"
    scalar = "void lappet::svd3<float>(float const (&) [9], float (&) [9])"
    listing = OWN + "".join(f"0000000000000000 W {symbol}\n" for symbol in (vector, narrow, scalar))
    assert shared_symbols(listing, "avx2") == [vector, narrow, scalar]


def test_the_entry_point_of_another_set_is_found() -> None:
    assert len(shared_symbols(OWN, "avx512")) == 2


def test_only_objects_named_after_a_set_are_kernel_units() -> None:
    assert instruction_set("elastic_kernels_avx512.cpp.o") == "avx512"
    assert instruction_set("elastic_kernels_neon.cpp.o") is None
    assert instruction_set("elastic_kernels_scalar.cpp.o") is None
    assert instruction_set("elastic.cpp.o") is None
