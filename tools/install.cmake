# What `cmake --install` leaves: the library with its header, what find_package(Palpate) reads, the programs, and beside
# them what all of these look up when they run. Nothing in it knows where it was built or installed.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(PACKAGE ${CMAKE_INSTALL_LIBDIR}/cmake/Palpate)

set(LIBRARIES palpate_library)
set(HEADERS engine/api/palpate.h engine/api/palpate_device.h)
if(PALPATE_APP)
  list(APPEND LIBRARIES palpate_image)
  list(APPEND HEADERS app/image/palpate_image.h)
endif()
install(TARGETS ${LIBRARIES} EXPORT PalpateTargets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT library)
install(FILES ${HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
install(EXPORT PalpateTargets NAMESPACE Palpate:: DESTINATION ${PACKAGE} COMPONENT library)
configure_package_config_file(tools/PalpateConfig.cmake.in ${PROJECT_BINARY_DIR}/PalpateConfig.cmake
                              INSTALL_DESTINATION ${PACKAGE})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/PalpateConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/PalpateConfig.cmake ${PROJECT_BINARY_DIR}/PalpateConfigVersion.cmake
        DESTINATION ${PACKAGE} COMPONENT library)
install(DIRECTORY assets/scenes assets/organs assets/tools DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate/assets
        COMPONENT library)
install(FILES assets/SOURCES.md DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate/assets COMPONENT library)
install(DIRECTORY tools/python DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate COMPONENT library
        PATTERN __pycache__ EXCLUDE)

install(TARGETS mtled RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
if(PALPATE_APP)
  install(TARGETS palpate RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
  install(DIRECTORY shaders DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate COMPONENT library)
endif()

if(PALPATE_NATIVE)
  install(CODE "message(STATUS \"For this machine's kind of processor; for others: tools/build portable\")"
          ALL_COMPONENTS)
endif()
