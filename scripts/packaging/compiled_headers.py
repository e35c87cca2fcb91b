"""Debian packages of which the program contains headers alone, as scripts/cmake/TwinDependencies.cmake finds them; sbom_test compares with what
was compiled."""

HEADERS = ("libboost1.74-dev", "libcli11-dev", "libeigen3-dev", "libgl-dev", "libkainjow-mustache-dev", "liburdfdom-headers-dev",
           "nlohmann-json3-dev")
