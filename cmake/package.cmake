# SPDX-License-Identifier: Apache-2.0
# What find_package(gyrotherm) finds: each room with its headers, in an export of its own, so that who asks for COMPONENTS
# record needs neither the instruments' libraries nor Eigen to be there.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(GYROTHERM_PACKAGE_FOLDER ${CMAKE_INSTALL_LIBDIR}/cmake/gyrotherm)

# Called by gyrotherm_room, in the room's own folder: its headers lie as they do here, below include/gyrotherm.
function(gyrotherm_package_room name)
  cmake_parse_arguments(room "" "" "USES;THIRD_PARTIES" ${ARGN})
  set_target_properties(gyrotherm_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(gyrotherm_${name} PUBLIC cxx_std_20)
  install(TARGETS gyrotherm_${name} EXPORT gyrotherm-${name} ARCHIVE COMPONENT development)
  install(EXPORT gyrotherm-${name} NAMESPACE gyrotherm:: DESTINATION ${GYROTHERM_PACKAGE_FOLDER} COMPONENT development)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  install(DIRECTORY . DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gyrotherm/${folder} COMPONENT development
    FILES_MATCHING PATTERN "*.hpp")
  set_property(GLOBAL APPEND PROPERTY GYROTHERM_ROOMS ${name})
  set_property(GLOBAL PROPERTY GYROTHERM_USES_${name} ${room_USES})
  set_property(GLOBAL PROPERTY GYROTHERM_THIRD_PARTIES_${name} ${room_THIRD_PARTIES})
endfunction()

# Puts into `result` the rooms that `name` rests on and itself, each after those that it rests on.
function(gyrotherm_rests_on name result)
  set(found)
  get_property(uses GLOBAL PROPERTY GYROTHERM_USES_${name})
  foreach(other IN LISTS uses)
    gyrotherm_rests_on(${other} below)
    list(APPEND found ${below})
  endforeach()
  list(APPEND found ${name})
  list(REMOVE_DUPLICATES found)
  set(${result} ${found} PARENT_SCOPE)
endfunction()

# Writes the package's files; called once, when every room is known.
function(gyrotherm_package)
  get_property(rooms GLOBAL PROPERTY GYROTHERM_ROOMS)
  set(GYROTHERM_TABLE "set(gyrotherm_rooms ${rooms})\n")
  foreach(room IN LISTS rooms)
    gyrotherm_rests_on(${room} below)
    get_property(third_parties GLOBAL PROPERTY GYROTHERM_THIRD_PARTIES_${room})
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_${room}_rests_on ${below})\n")
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_${room}_third_parties ${third_parties})\n")
  endforeach()
  foreach(module IN ITEMS libmodbus hidapi libserialport netcdf zlib)
    string(APPEND GYROTHERM_TABLE "set(gyrotherm_module_of_${module} ${${module}_MODULE_NAME})\n")
  endforeach()
  set(folder ${PROJECT_BINARY_DIR}/package)
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/gyrothermConfig.cmake.in ${folder}/gyrothermConfig.cmake
    INSTALL_DESTINATION ${GYROTHERM_PACKAGE_FOLDER} NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  write_basic_package_version_file(${folder}/gyrothermConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${folder}/gyrothermConfig.cmake ${folder}/gyrothermConfigVersion.cmake
    DESTINATION ${GYROTHERM_PACKAGE_FOLDER} COMPONENT development)
endfunction()
