# The header of Debian's cppzmq-dev, with the libzmq that packaging/windows/cross_build.sh compiled.
add_library(cppzmq INTERFACE IMPORTED)
target_include_directories(cppzmq SYSTEM INTERFACE "${LAPPET_WINDOWS_PREFIX}/include"
                           "${LAPPET_WINDOWS_PREFIX}/headers")
target_compile_definitions(cppzmq INTERFACE ZMQ_STATIC)
target_link_libraries(cppzmq INTERFACE "${LAPPET_WINDOWS_PREFIX}/lib/libzmq.a" ws2_32 iphlpapi)
