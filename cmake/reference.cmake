# SPDX-License-Identifier: Apache-2.0
# Adds the target `reference`: doxygen pages of the modules' headers, in BUILD/reference/html. A warning is an error.
function(gyrotherm_reference)
  find_package(Doxygen REQUIRED)
  set(modules core drivers sequencer acquisition analysis simulator report)
  list(TRANSFORM modules REPLACE "(.+)" "\"${PROJECT_SOURCE_DIR}/\\1\"" OUTPUT_VARIABLE folders)
  list(JOIN folders " " GYROTHERM_DOCUMENTED)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  add_custom_target(reference COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/Doxyfile
    COMMENT "The reference of the headers, into ${PROJECT_BINARY_DIR}/reference/html" USES_TERMINAL)
endfunction()
