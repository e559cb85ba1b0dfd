# SPDX-License-Identifier: Apache-2.0
# What is installed beside the programs: units, completions, manual pages.
include(GNUInstallDirs)

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
