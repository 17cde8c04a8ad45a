# Read by cpack for each generator. CPACK_PALPATE_NATIVE is PALPATE_NATIVE of the build.
if(CPACK_PALPATE_NATIVE)
  message(FATAL_ERROR "this build is for this machine's kind of processor; make packages with tools/packages, or of "
                      "build/portable")
endif()
