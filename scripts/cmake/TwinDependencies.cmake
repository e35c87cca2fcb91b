# Everything we use from Debian 12, in one place.
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)  # the program's log; no library links it
find_package(nlohmann_json REQUIRED)
find_path(TWIN_MUSTACHE kainjow/mustache.hpp REQUIRED)  # headers only, in the default path
find_package(Protobuf REQUIRED)
find_package(PNG REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(OSMESA REQUIRED IMPORTED_TARGET osmesa)
pkg_check_modules(LIBEVDEV REQUIRED IMPORTED_TARGET libevdev)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)
find_package(urdfdom REQUIRED)
find_package(assimp REQUIRED)
find_package(meshoptimizer REQUIRED)

# Asio and Beast for the operator's page; of Boost only headers are used, in the default path.
find_package(Boost 1.74 REQUIRED)

# Debian's mujoco package names a qhull include folder that does not exist; its headers are in the default path anyway.
find_package(mujoco 2.2.2 REQUIRED)
set_target_properties(mujoco::mujoco PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")

# Debian's ompl package lists libraries of Boost, of which we need none: libompl alone, and its headers.
find_package(ompl 1.5 REQUIRED)
add_library(OMPL::OMPL INTERFACE IMPORTED)
target_include_directories(OMPL::OMPL INTERFACE ${OMPL_INCLUDE_DIR})
target_link_libraries(OMPL::OMPL INTERFACE ompl)

if(TWIN_BUILD_TESTS)
  find_package(GTest REQUIRED)
  find_package(Qhull REQUIRED)
endif()
if(TWIN_LTTNG)
  pkg_check_modules(LTTNG_UST REQUIRED IMPORTED_TARGET lttng-ust)
endif()
if(TWIN_BUILD_BENCH)
  find_package(benchmark REQUIRED)
endif()
