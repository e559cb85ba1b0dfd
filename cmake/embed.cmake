# SPDX-License-Identifier: Apache-2.0
# gyrotherm_embed(TARGET HEADER NAMESPACE FUNCTION=FILE …) compiles text files of installed packages into a target: HEADER, of
# the repository, declares functions that return a std::string_view, and what is generated in the build tree defines them.
# A file's reference to its source map is left out: nobody has that map. Run as a script it writes one such source.
function(gyrotherm_embed target header namespace)
  foreach(pair IN LISTS ARGN)
    string(REGEX MATCH "^([a-z_]+)=(.+)$" found "${pair}")
    set(function ${CMAKE_MATCH_1})
    set(file ${CMAKE_MATCH_2})
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
    add_custom_command(OUTPUT ${source}
      COMMAND ${CMAKE_COMMAND} -DHEADER=${header} -DNAMESPACE=${namespace} -DFUNCTION=${function} -DFILE=${file}
        -DSOURCE=${source} -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
      DEPENDS ${file} ${PROJECT_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
    set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    target_sources(${target} PRIVATE ${source})
  endforeach()
endfunction()

if(CMAKE_SCRIPT_MODE_FILE)
  file(READ "${FILE}" text)
  string(REGEX REPLACE "(//|/\\*)# sourceMappingURL=[^\n]*" "" text "${text}")
  file(WRITE "${SOURCE}" "#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n\n"
    "std::string_view ${FUNCTION}() {\n  return R\"embedded(${text})embedded\";\n}\n\n}  // namespace ${NAMESPACE}\n")
endif()
