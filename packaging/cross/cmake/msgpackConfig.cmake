# The headers of Debian's libmsgpack-cxx-dev, and those of Boost that they include.
add_library(msgpackc-cxx INTERFACE IMPORTED)
target_include_directories(msgpackc-cxx SYSTEM INTERFACE "${LAPPET_CROSS}/headers")
