# SPDX-License-Identifier: Apache-2.0
# The target reference: what doxygen makes of the rooms' headers, in BUILD/reference/html; any warning of it is an error.
function(gyrotherm_reference)
  find_package(Doxygen REQUIRED)
  set(rooms core drivers sequencer acquisition analysis plot thermal simulator rig report)
  list(TRANSFORM rooms REPLACE "(.+)" "\"${PROJECT_SOURCE_DIR}/\\1\"" OUTPUT_VARIABLE folders)
  list(JOIN folders " " GYROTHERM_DOCUMENTED)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  add_custom_target(reference COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/Doxyfile
    COMMENT "The reference of the headers, into ${PROJECT_BINARY_DIR}/reference/html" USES_TERMINAL)
endfunction()
