# What `cmake --install` leaves: the library with its header, what find_package(Palpate) reads, the programs, and beside
# them what all of these look up when they run. Nothing in it knows where it was built or installed.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(PACKAGE ${CMAKE_INSTALL_LIBDIR}/cmake/Palpate)

# Components are Debian packages, too (tools/packages.cmake); a plain install takes them all.
set(HEADERS engine/api/palpate.h engine/api/palpate_device.h)
install(TARGETS palpate_library EXPORT PalpateTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
        NAMELINK_COMPONENT development)
if(PALPATE_APP)
  list(APPEND HEADERS app/image/palpate_image.h)
  install(TARGETS palpate_image EXPORT PalpateTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT image
          NAMELINK_COMPONENT development)
endif()
install(FILES ${HEADERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(EXPORT PalpateTargets NAMESPACE Palpate:: DESTINATION ${PACKAGE} COMPONENT development)
configure_package_config_file(tools/PalpateConfig.cmake.in ${PROJECT_BINARY_DIR}/PalpateConfig.cmake
                              INSTALL_DESTINATION ${PACKAGE})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/PalpateConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/PalpateConfig.cmake ${PROJECT_BINARY_DIR}/PalpateConfigVersion.cmake
        DESTINATION ${PACKAGE} COMPONENT development)
function(palpate_pkg_config NAME WHAT REQUIRES)
  file(RELATIVE_PATH UP /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  configure_file(tools/packaging/palpate.pc.in ${PROJECT_BINARY_DIR}/${NAME}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${NAME}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endfunction()
palpate_pkg_config(palpate "Soft tissue under a tool, in real time or step by step" "")
if(PALPATE_APP)
  palpate_pkg_config(palpate_image "Pictures of Palpate's simulations" palpate)
endif()

install(DIRECTORY assets/scenes assets/organs assets/tools DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate/assets
        COMPONENT data)
install(FILES assets/SOURCES.md DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate/assets COMPONENT data)
# Beside the rest, where a moved folder keeps it; in a package where Debian's Python looks.
install(DIRECTORY tools/python DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate COMPONENT python_beside
        PATTERN __pycache__ EXCLUDE PATTERN build EXCLUDE PATTERN *.egg-info EXCLUDE)
install(DIRECTORY tools/python/palpate DESTINATION lib/python3/dist-packages COMPONENT python EXCLUDE_FROM_ALL
        PATTERN __pycache__ EXCLUDE)

install(TARGETS mtled RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
if(PALPATE_APP)
  install(TARGETS palpate RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
  install(DIRECTORY shaders DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate COMPONENT data)
endif()

if(TARGET palpate_igtl)
  set_target_properties(palpate_igtl PROPERTIES INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
  install(TARGETS palpate_igtl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT igtl)
endif()

if(PALPATE_NATIVE)
  install(CODE "message(STATUS \"For this machine's kind of processor; for others: tools/build portable\")"
          ALL_COMPONENTS)
endif()
