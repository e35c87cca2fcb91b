# cmake --install, the exported package panda_twin, the target uninstall, and cpack -G DEB.
include(CMakePackageConfigHelpers)

set(TWIN_INSTALL_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/panda_twin)
set(TWIN_INSTALL_DATADIR ${CMAKE_INSTALL_DATADIR}/panda_twin)
set(TWIN_INSTALL_DOCDIR ${CMAKE_INSTALL_DATADIR}/doc/panda-twin)

get_property(twin_areas GLOBAL PROPERTY TWIN_AREAS)
install(TARGETS ${twin_areas} EXPORT panda_twin ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/twin DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
if(EXISTS ${PROJECT_SOURCE_DIR}/models)
  install(DIRECTORY models/ DESTINATION ${TWIN_INSTALL_DATADIR}/models)
endif()
install(FILES LICENSE NOTICE CHANGELOG.md DESTINATION ${TWIN_INSTALL_DOCDIR})
install(FILES NOTICE DESTINATION ${TWIN_INSTALL_DOCDIR} RENAME copyright)

if(TARGET panda-twin)
  install(TARGETS panda-twin RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(TARGET panda-twin-campaign)  # for those who try their own controllers; built with the tests, not by scripts/demo
  install(TARGETS panda-twin-campaign RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)
endif()

# The package: find_package(panda_twin) gives twin::core, twin::rt and so on.
install(EXPORT panda_twin NAMESPACE twin:: FILE panda_twin-targets.cmake DESTINATION ${TWIN_INSTALL_CMAKEDIR})
list(TRANSFORM twin_areas REPLACE "^twin_" "twin::" OUTPUT_VARIABLE TWIN_AREA_TARGETS)
configure_package_config_file(scripts/cmake/panda_twin-config.cmake.in ${CMAKE_BINARY_DIR}/panda_twin-config.cmake
  INSTALL_DESTINATION ${TWIN_INSTALL_CMAKEDIR}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/panda_twin-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/panda_twin-config.cmake ${CMAKE_BINARY_DIR}/panda_twin-config-version.cmake
        DESTINATION ${TWIN_INSTALL_CMAKEDIR})

add_custom_target(uninstall
  COMMAND ${CMAKE_COMMAND} -D MANIFEST=${CMAKE_BINARY_DIR}/install_manifest.txt
          -P ${PROJECT_SOURCE_DIR}/scripts/cmake/TwinUninstall.cmake
  COMMENT "Removing what the last install wrote"
  VERBATIM)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME panda-twin)
set(CPACK_PACKAGE_VENDOR "The panda-twin maintainers")
set(CPACK_PACKAGE_CONTACT "The panda-twin maintainers <maintainers@panda-twin.invalid>")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/package)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "gnuplot-nox | gnuplot, ffmpeg")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "digital twin of the Franka Emika Panda and its control stack
 Runs the arm's 1 kHz control stack against a MuJoCo model that behaves, command by command, as the robot's own
 controller does. Robot and workstation share one deterministic time line, and every cycle is recorded.")
include(CPack)
