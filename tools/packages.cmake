# `cpack` in a build folder makes Debian packages, one for each component of tools/install.cmake; tools/packages builds
# and tries them. They run on any x86-64, so a build for this machine's processor is refused.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME palpate)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_CONTACT "The Palpate project <palpate@localhost>" CACHE STRING "Maintainer of the packages")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/tools/packaging/refuse_native.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})

# @param name  the package's
# @param NEEDS  components whose packages it depends on, in the same version; ASKS  and beside what shlibdeps finds
# @param WISHES  packages that it recommends; ALL  the same for all processors
function(palpate_package component name)
  cmake_parse_arguments(package "ALL" "SECTION;WHAT" "NEEDS;ASKS;WISHES" ${ARGN})
  string(TOUPPER ${component} key)
  list(JOIN package_ASKS ", " depends)
  list(JOIN package_WISHES ", " recommends)
  foreach(pair "DEBIAN_${key}_PACKAGE_NAME=${name}" "DEBIAN_${key}_DEBUGINFO_PACKAGE=OFF"
          "DEBIAN_${key}_PACKAGE_SECTION=${package_SECTION}" "DEBIAN_${key}_PACKAGE_DEPENDS=${depends}"
          "DEBIAN_${key}_PACKAGE_RECOMMENDS=${recommends}" "COMPONENT_${key}_DESCRIPTION=${package_WHAT}"
          "COMPONENT_${key}_DEPENDS=${package_NEEDS}")
    string(FIND "${pair}" "=" at)
    string(SUBSTRING "${pair}" 0 ${at} variable)
    math(EXPR at "${at} + 1")
    string(SUBSTRING "${pair}" ${at} -1 value)
    set(CPACK_${variable} "${value}" PARENT_SCOPE)
  endforeach()
  if(package_ALL)
    set(CPACK_DEBIAN_${key}_PACKAGE_ARCHITECTURE all PARENT_SCOPE)
    set(CPACK_DEBIAN_${key}_PACKAGE_SHLIBDEPS OFF PARENT_SCOPE)
  endif()
  install(FILES ${PROJECT_SOURCE_DIR}/tools/packaging/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
          COMPONENT ${component} EXCLUDE_FROM_ALL)
  # The terms of what is compiled in, as Debian has them.
  foreach(part libeigen3-dev libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libnanoflann-dev libimgui-dev)
    if(NOT package_ALL AND EXISTS /usr/share/doc/${part}/copyright)
      install(FILES /usr/share/doc/${part}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
              RENAME copyright.${part} COMPONENT ${component} EXCLUDE_FROM_ALL)
    endif()
  endforeach()
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

# GLFW loads the first four while it runs; Mesa draws where there is no other driver.
set(WINDOW libxrandr2 libxi6 libxcursor1 libxinerama1 libegl1 libgl1)
set(DRIVERS libegl-mesa0 libgl1-mesa-dri)
palpate_package(data palpate-data ALL SECTION science WHAT "Scenes, organs, tool scripts and shaders of Palpate.")
palpate_package(library libpalpate NEEDS data SECTION libs
                WHAT "Palpate as a C library: soft tissue under a tool, step by step or in real time.")
palpate_package(python python3-palpate ALL NEEDS library ASKS python3 python3-numpy SECTION python
                WHAT "Palpate in Python: models, simulations, environments for reinforcement learning.")
# What Python has kept beside the package goes with it.
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/tools/packaging/prerm)
if(PALPATE_APP)
  palpate_package(programs palpate NEEDS data ASKS ${WINDOW} WISHES ${DRIVERS} fonts-dejavu-core SECTION science
                  WHAT "Press a probe into soft tissue and read the force: palpate, and mtled for batch work.")
  palpate_package(image libpalpate-image NEEDS library ASKS libegl1 libgl1 WISHES ${DRIVERS} SECTION libs
                  WHAT "Pictures of Palpate's simulations, drawn without a window.")
  palpate_package(development libpalpate-dev NEEDS library image SECTION libdevel
                  WHAT "Headers, pkg-config and CMake files of libpalpate and libpalpate-image.")
else()
  palpate_package(programs palpate NEEDS data SECTION science WHAT "mtled: soft tissue simulated in batch.")
  palpate_package(development libpalpate-dev NEEDS library SECTION libdevel
                  WHAT "Header, pkg-config and CMake files of libpalpate.")
endif()
if(TARGET palpate_igtl)
  palpate_package(igtl palpate-igtl NEEDS library SECTION science
                  WHAT "A server of OpenIGTLink, for 3D Slicer: a tracked tool in, force and tissue out.")
endif()
set(CPACK_PALPATE_NATIVE ${PALPATE_NATIVE})
include(CPack)
