# SPDX-License-Identifier: Apache-2.0
# The target manual: docs/ and each command's manual page as a site, in BUILD/manual/html; any warning is an error. It is
# there where Sphinx is, and part of what is built and installed if GYROTHERM_MANUAL is on.
include(GNUInstallDirs)
find_package(Python3 COMPONENTS Interpreter)
set(GYROTHERM_SPHINX "")  # the Python that has Sphinx and MyST
foreach(python IN ITEMS ${Python3_EXECUTABLE} /usr/bin/python3)  # Debian's has Debian's packages
  execute_process(COMMAND ${python} -c "import myst_parser, sphinx" RESULT_VARIABLE missing ERROR_QUIET OUTPUT_QUIET)
  if(missing EQUAL 0)
    set(GYROTHERM_SPHINX ${python})
    break()
  endif()
endforeach()
if(GYROTHERM_MANUAL AND NOT GYROTHERM_SPHINX)
  message(FATAL_ERROR "The manual needs Sphinx and MyST: python3-sphinx and python3-myst-parser")
endif()
if(GYROTHERM_SPHINX)
  set(part)
  if(GYROTHERM_MANUAL)
    set(part ALL)
    install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/html/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/html
      PATTERN ".buildinfo" EXCLUDE PATTERN "objects.inv" EXCLUDE)
  endif()
  add_custom_target(manual ${part}
    COMMAND ${GYROTHERM_SPHINX} ${PROJECT_SOURCE_DIR}/docs/site/make.py --pages ${PROJECT_BINARY_DIR}/man
      --out ${PROJECT_BINARY_DIR}/manual --version ${PROJECT_VERSION}
    COMMENT "The manual's site, into ${PROJECT_BINARY_DIR}/manual/html"
    VERBATIM)
  add_dependencies(manual manual-pages)
endif()
