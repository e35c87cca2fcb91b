# Precompiled headers: without them more than half of a build's time goes into gtest, Eigen, fmt and the standard library.
# Sources include what they use all the same: scripts/lint and -DTWIN_PCH=OFF compile without.
#
#   twin_pch_for_libraries(target)        for optimised code of ours
#   twin_pch_for_libraries(target COLD)   for code whose own speed nobody notices: -O1 compiles in two thirds of the time
#   twin_pch_for_tests(target)            for tests' own sources; twin_add_test does it
#
# g++ takes a precompiled header only under the options and macros it was made with, and warns otherwise (-Winvalid-pch). Other
# compilers ask for more, and do without.
option(TWIN_PCH "Precompile the headers that are not ours" ON)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(TWIN_PCH OFF)
endif()

set(TWIN_STANDARD_HEADERS
  <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional> <limits> <map> <memory>
  <numbers> <numeric> <optional> <set> <span> <sstream> <string> <string_view> <system_error> <thread> <utility> <variant>
  <vector>)

function(twin_precompile target)
  file(WRITE ${CMAKE_BINARY_DIR}/pch/${target}.cc "")
  add_library(${target} OBJECT ${CMAKE_BINARY_DIR}/pch/${target}.cc)
  target_link_libraries(${target} PRIVATE twin_warnings fmt::fmt Eigen3::Eigen)
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_compile_options(${target} PRIVATE ${ARGN})
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_precompile_headers(${target} PRIVATE ${TWIN_STANDARD_HEADERS} <fmt/format.h> <Eigen/Core> <Eigen/Geometry>)
endfunction()
if(TWIN_PCH)
  twin_precompile(twin_library_headers)
  if(CMAKE_BUILD_TYPE STREQUAL "Release")
    twin_precompile(twin_cold_headers -O1)
  endif()
endif()

function(twin_pch_for_libraries target)
  set(headers twin_library_headers)
  if(COLD IN_LIST ARGN AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
    set(headers twin_cold_headers)
  endif()
  if(TWIN_PCH)
    target_compile_options(${target} PRIVATE -fPIC)
    target_compile_definitions(${target} PRIVATE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endif()
endfunction()

function(twin_pch_for_tests target)
  if(TWIN_PCH)
    target_precompile_headers(${target} REUSE_FROM twin_test_main)
  endif()
endfunction()
