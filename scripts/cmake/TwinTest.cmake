# A test: twin_add_test(rt_event_queue_test LABELS unit LINK twin::rt). Source: <name>.cc beside the CMakeLists, or SOURCES. All tests
# of a folder are one program, rt_tests; `rt_tests rt_event_queue_test` runs the cases of that source. ALONE makes a program of its own.
# Every test is named here, never globbed. A program in which no test would run fails (tests/support/test_main.cc). The
# namespace of each source ends with the source's name, because several are compiled as one (TwinUnity.cmake).
#
# A test that is a Python script: twin_add_script_test(name SCRIPT check.py ARGS ... LABELS unit NEEDS panda-twin).
#
# Labels: unit (seconds, no network, no GPU, no luck), contract, rt (wall clock; whatever the machine does), stress (threads; also
# for tsan), video, package (installs), bench, slow. The targets unit_tests and stress_tests build all that those labels need.
# Unit tests of folders that handle untrusted bytes, threads or raw memory are also labelled memory (target memory_tests): those
# that .ci/run repeats under asan. The others compute; the nightly runs them under asan (`scripts/test --preset asan -L unit`).
#
# A test program of which a case was skipped is "Skipped" to ctest, whatever else passed: it ends with TWIN_SKIPPED, or is a
# unittest, which says so in its last line. scripts/run-tests tells the reasons. A test that this build cannot have, for want of
# something that scripts/setup installs, is registered all the same: twin_register_missing_test(name WANTS "what" LABELS ...).
set(TWIN_SKIPPED 77)
set(TWIN_UNITTEST_SKIPPED "\nOK \\(skipped=[0-9]+\\)")

# The tests' Python: .venv, made by scripts/setup, has the packages of scripts/requirements-test.txt.
if(EXISTS ${PROJECT_SOURCE_DIR}/.venv/bin/python)
  set(TWIN_TEST_PYTHON ${PROJECT_SOURCE_DIR}/.venv/bin/python)
else()
  set(TWIN_TEST_PYTHON python3)
endif()

# Of tests that play a person at a browser: it has Debian's python3-selenium, which .venv does not see.
find_program(TWIN_SYSTEM_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH DOC "Python of the system")
mark_as_advanced(TWIN_SYSTEM_PYTHON)

# A test's own source takes longer to compile than it runs; what it tests is compiled as everywhere.
set(TWIN_TEST_FLAGS -O0 CACHE STRING "How the tests' own sources are compiled")
mark_as_advanced(TWIN_TEST_FLAGS)

# There are hundreds of test programs, and lld links one in a quarter of the time. What is installed is linked as always.
find_program(TWIN_LLD ld.lld DOC "Linker of the test programs, used when present")
mark_as_advanced(TWIN_LLD)

if(TWIN_BUILD_TESTS)
  add_custom_target(unit_tests)
  add_custom_target(stress_tests)
  add_custom_target(memory_tests)
endif()
set(TWIN_MEMORY_FOLDERS support core rt record fci plant robot server proxy backend control loop contract
    devices fuzz)

function(twin_add_test name)
  cmake_parse_arguments(TEST "ALONE" "TIMEOUT" "SOURCES;LABELS;LINK" ${ARGN})
  if(NOT TEST_SOURCES)
    set(TEST_SOURCES ${name}.cc)
  endif()
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
  if(TEST_ALONE)
    set(program ${name})
    set(cases "")
  else()
    set(program ${folder}_tests)
    list(GET TEST_SOURCES 0 source)
    cmake_path(GET source STEM cases)
  endif()
  if(NOT TARGET ${program})
    add_executable(${program})
    twin_compile_as_test(${program})
    twin_unity(${program})
    target_link_libraries(${program} PRIVATE twin_test_main)
    if(TWIN_LLD)
      target_link_options(${program} PRIVATE -fuse-ld=lld)
    endif()
  endif()
  target_sources(${program} PRIVATE ${TEST_SOURCES})
  target_link_libraries(${program} PRIVATE ${TEST_LINK})
  twin_register_test(${name} COMMAND ${program} ${cases} LABELS "${TEST_LABELS}" TIMEOUT "${TEST_TIMEOUT}" NEEDS ${program})
endfunction()

# Also for an object library of tests that several programs take: SOURCES $<TARGET_OBJECTS:name>.
function(twin_compile_as_test target)
  target_link_libraries(${target} PRIVATE twin_warnings GTest::gmock)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/src)
  target_compile_definitions(${target} PRIVATE TWIN_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_compile_options(${target} PRIVATE ${TWIN_TEST_FLAGS} -U_FORTIFY_SOURCE)
  twin_pch_for_tests(${target})
endfunction()

function(twin_add_script_test name)
  cmake_parse_arguments(TEST "" "SCRIPT;TIMEOUT" "ARGS;LABELS;NEEDS" ${ARGN})
  cmake_path(ABSOLUTE_PATH TEST_SCRIPT BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
  file(STRINGS ${TEST_SCRIPT} is_unittest REGEX "unittest\\.main")
  if(is_unittest)
    list(APPEND TEST_ARGS -v)  # without it no reason of a skip is told
  endif()
  twin_register_test(${name} COMMAND ${TWIN_TEST_PYTHON} -B ${TEST_SCRIPT} ${TEST_ARGS}
                     LABELS "${TEST_LABELS}" TIMEOUT "${TEST_TIMEOUT}" NEEDS ${TEST_NEEDS})
endfunction()

# The longest tests, begun first: a build that has not run them yet would else wait for one of them at the end.
set(TWIN_LONG_TESTS panda_python_realtime_test campaign_test ros2_rclpy_test sweep_test video_test applications_lockstep_test render_test cli_test
    experiment_test conformance_error_table_wire_test run_plan_places_test examples_test conformance_random_streams trace_test
    own_client_realtime_test page_scene_test python_envs_test)

# What both have in common: label (unit unless told), time limit in seconds (300 unless told: for what hangs, not for what a busy machine
# holds up), part in unit_tests.
function(twin_register_test name)
  cmake_parse_arguments(TEST "" "TIMEOUT" "COMMAND;LABELS;NEEDS" ${ARGN})
  if(NOT TEST_LABELS)
    set(TEST_LABELS unit)
  endif()
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 300)
  endif()
  cmake_path(GET CMAKE_CURRENT_SOURCE_DIR FILENAME folder)
  if("unit" IN_LIST TEST_LABELS AND "${folder}" IN_LIST TWIN_MEMORY_FOLDERS AND NOT panda-twin IN_LIST TEST_NEEDS)
    list(APPEND TEST_LABELS memory)
  endif()
  add_test(NAME ${name} COMMAND ${TEST_COMMAND})
  # XDG_STATE_HOME keeps what runs leave about themselves out of the user's folders. LSAN_OPTIONS and TSAN_OPTIONS
  # count under their presets only: what libraries do is named there, what we do fails.
  set_tests_properties(${name} PROPERTIES LABELS "${TEST_LABELS}" TIMEOUT ${TEST_TIMEOUT}
    SKIP_RETURN_CODE ${TWIN_SKIPPED} SKIP_REGULAR_EXPRESSION "${TWIN_UNITTEST_SKIPPED}"
    ENVIRONMENT "XDG_STATE_HOME=${CMAKE_BINARY_DIR}/state;LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/support/lsan.supp:print_suppressions=0;TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/support/tsan.supp:print_suppressions=0")
  if(name IN_LIST TWIN_LONG_TESTS)
    set_tests_properties(${name} PROPERTIES COST 1)
  endif()
  foreach(label unit stress memory)
    if(TEST_NEEDS AND "${label}" IN_LIST TEST_LABELS)
      add_dependencies(${label}_tests ${TEST_NEEDS})
    endif()
  endforeach()
endfunction()

# A test that says why it is none.
function(twin_register_missing_test name)
  cmake_parse_arguments(TEST "" "WANTS" "LABELS" ${ARGN})
  twin_register_test(${name} COMMAND sh -c "echo \"missing: ${TEST_WANTS}\" && exit ${TWIN_SKIPPED}" LABELS "${TEST_LABELS}")
endfunction()
