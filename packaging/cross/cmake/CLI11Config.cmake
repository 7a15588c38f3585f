# The headers of Debian's libcli11-dev.
add_library(CLI11::CLI11 INTERFACE IMPORTED)
target_include_directories(CLI11::CLI11 SYSTEM INTERFACE "${LAPPET_CROSS}/headers")
