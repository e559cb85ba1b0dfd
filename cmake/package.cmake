# SPDX-License-Identifier: Apache-2.0
# Installs what find_package(gyrotherm) finds: each module with its headers, in an export of its own, so that a user of
# COMPONENTS record needs neither the instruments' libraries nor Eigen.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(GYROTHERM_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/gyrotherm)

# Installs a module; gyrotherm_module() calls it in the module's own folder. Headers keep their path below
# include/gyrotherm.
function(gyrotherm_package_module name)
  cmake_parse_arguments(module "" "" "USES;THIRD_PARTIES" ${ARGN})
  set_target_properties(gyrotherm_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(gyrotherm_${name} PUBLIC cxx_std_20)
  install(TARGETS gyrotherm_${name} EXPORT gyrotherm-${name} ARCHIVE COMPONENT development)
  install(EXPORT gyrotherm-${name} NAMESPACE gyrotherm:: DESTINATION ${GYROTHERM_PACKAGE_FOLDER} COMPONENT development)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  install(DIRECTORY . DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gyrotherm/${folder} COMPONENT development
    FILES_MATCHING PATTERN "*.hpp")
  set_property(GLOBAL APPEND PROPERTY GYROTHERM_MODULES ${name})
  set_property(GLOBAL PROPERTY GYROTHERM_USES_${name} ${module_USES})
  set_property(GLOBAL PROPERTY GYROTHERM_THIRD_PARTIES_${name} ${module_THIRD_PARTIES})
endfunction()

# Lists the modules that `name` depends on and `name` itself, each after its own dependencies.
function(gyrotherm_dependencies name result)
  set(found)
  get_property(uses GLOBAL PROPERTY GYROTHERM_USES_${name})
  foreach(other IN LISTS uses)
    gyrotherm_dependencies(${other} below)
    list(APPEND found ${below})
  endforeach()
  list(APPEND found ${name})
  list(REMOVE_DUPLICATES found)
  set(${result} ${found} PARENT_SCOPE)
endfunction()

# Writes the package's files; called once, after all modules.
function(gyrotherm_package)
  get_property(modules GLOBAL PROPERTY GYROTHERM_MODULES)
  set(GYROTHERM_TABLE "set(gyrotherm_modules ${modules})\n")
  foreach(module IN LISTS modules)
    gyrotherm_dependencies(${module} below)
    get_property(third_parties GLOBAL PROPERTY GYROTHERM_THIRD_PARTIES_${module})
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_${module}_depends_on ${below})\n")
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_${module}_third_parties ${third_parties})\n")
  endforeach()
  foreach(library IN ITEMS libmodbus hidapi libserialport netcdf zlib)
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_pkgconfig_of_${library} ${${library}_MODULE_NAME})\n")
  endforeach()
  set(folder ${PROJECT_BINARY_DIR}/package)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/gyrothermConfig.cmake.in ${folder}/gyrothermConfig.cmake
    INSTALL_DESTINATION ${GYROTHERM_PACKAGE_FOLDER} NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  write_basic_package_version_file(${folder}/gyrothermConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${folder}/gyrothermConfig.cmake ${folder}/gyrothermConfigVersion.cmake
    DESTINATION ${GYROTHERM_PACKAGE_FOLDER} COMPONENT development)
endfunction()
