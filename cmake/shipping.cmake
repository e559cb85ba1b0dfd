# SPDX-License-Identifier: Apache-2.0
# What is installed beside the programs: units, completions, manual pages.
include(GNUInstallDirs)
string(TIMESTAMP GYROTHERM_DATE "%Y-%m-%d" UTC)  # of the release, where SOURCE_DATE_EPOCH says it

# A unit of systemd. Where its programs and documents are is known when it is installed, under whatever prefix.
function(gyrotherm_unit source)
  cmake_path(GET source STEM LAST_ONLY unit)
  install(CODE "
    cmake_path(ABSOLUTE_PATH CMAKE_INSTALL_PREFIX NORMALIZE OUTPUT_VARIABLE prefix)
    set(GYROTHERM_BIN \"\${prefix}/${CMAKE_INSTALL_BINDIR}\")
    set(GYROTHERM_DOCS \"\${prefix}/${CMAKE_INSTALL_DOCDIR}\")
    configure_file(\"${CMAKE_CURRENT_SOURCE_DIR}/${source}\" \"${PROJECT_BINARY_DIR}/systemd/${unit}\" @ONLY)
    file(INSTALL \"${PROJECT_BINARY_DIR}/systemd/${unit}\" DESTINATION \"\${prefix}/lib/systemd/system\")")
endfunction()

# What the shells complete a program's command lines with, said by the program itself.
function(gyrotherm_completions program)
  set(made)
  foreach(shell bash zsh fish)
    set(file ${PROJECT_BINARY_DIR}/completions/${program}.${shell})
    add_custom_command(OUTPUT ${file} COMMAND ${program} completion ${shell} > ${file} DEPENDS ${program} VERBATIM)
    list(APPEND made ${file})
  endforeach()
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/completions)
  add_custom_target(${program}-completions ALL DEPENDS ${made})
  set(from ${PROJECT_BINARY_DIR}/completions/${program})
  install(FILES ${from}.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${program})
  install(FILES ${from}.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _${program})
  install(FILES ${from}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
endfunction()

# A manual page of each prose in docs/man: with what `manual` adds of the program, or else of the command, of that name;
# or as it is where it begins with "# NAME", for it has the options, too.
function(gyrotherm_manual_pages)
  file(GLOB proses CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/man/*.md)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/man)
  set(pages)
  foreach(prose ${proses})
    cmake_path(GET prose STEM page)
    file(STRINGS ${prose} beginning LIMIT_COUNT 1)
    if(beginning STREQUAL "# NAME")
      set(command gyrotherm manual --name ${page})
    elseif(TARGET ${page})
      set(command ${page} manual)
    else()
      string(REGEX REPLACE "^gyrotherm-" "" name ${page})
      set(command gyrotherm manual ${name})
    endif()
    list(GET command 0 program)
    set(file ${PROJECT_BINARY_DIR}/man/${page}.1)
    add_custom_command(OUTPUT ${file}
      COMMAND ${command} --prose ${prose} --date ${GYROTHERM_DATE} > ${file}
      DEPENDS ${program} ${prose} VERBATIM)
    list(APPEND pages ${file})
  endforeach()
  add_custom_target(manual-pages ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endfunction()
