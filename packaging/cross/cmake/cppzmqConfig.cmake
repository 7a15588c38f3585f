# The header of Debian's cppzmq-dev, with the libzmq that packaging/cross/build.sh compiled.
add_library(cppzmq INTERFACE IMPORTED)
target_include_directories(cppzmq SYSTEM INTERFACE "${LAPPET_CROSS_PREFIX}/include" "${LAPPET_CROSS}/headers")
target_compile_definitions(cppzmq INTERFACE ZMQ_STATIC)
target_link_libraries(cppzmq INTERFACE "${LAPPET_CROSS_PREFIX}/lib/libzmq.a" $<$<BOOL:${WIN32}>:ws2_32;iphlpapi>)
