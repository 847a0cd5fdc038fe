# cmake --install: programs, library, headers under one prefix, a CMake package and a pkg-config file.
#
# One header is for users: <sagitta/sagitta.h>. What it includes, directly or not, goes to sagitta/detail/ with its
# #include lines rewritten, so that no header of ours lies outside sagitta/. Each includes sagitta/version.h.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

function(sagitta_collect_headers header collected)
  set(seen ${${collected}})
  if(header IN_LIST seen)
    return()
  endif()
  list(APPEND seen ${header})
  set(${collected} ${seen})
  file(STRINGS ${PROJECT_SOURCE_DIR}/${header} lines REGEX "^#include \"")
  foreach(line ${lines})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" next "${line}")
    sagitta_collect_headers(${next} ${collected})
  endforeach()
  set(${collected} ${${collected}} PARENT_SCOPE)
endfunction()

# What a consumer's compiler has to agree on with ours: of the flags that our code is compiled with.
set(SAGITTA_EIGEN_PROBE ${PROJECT_BINARY_DIR}/eigen_probe.cc)
file(WRITE ${SAGITTA_EIGEN_PROBE} [[#include <Eigen/Core>
#include <iostream>
int main() {
  std::cout << EIGEN_WORLD_VERSION << ";" << EIGEN_MAJOR_VERSION << ";" << EIGEN_MINOR_VERSION << ";"
            << EIGEN_DEFAULT_ALIGN_BYTES << ";" << EIGEN_MAX_ALIGN_BYTES << ";" << EIGEN_MAX_STATIC_ALIGN_BYTES;
}
]])
unset(SAGITTA_EIGEN_RUNS CACHE)  # asked again: flags may have changed
try_run(SAGITTA_EIGEN_RUNS SAGITTA_EIGEN_COMPILES ${PROJECT_BINARY_DIR}/eigen_probe ${SAGITTA_EIGEN_PROBE}
  LINK_LIBRARIES Eigen3::Eigen RUN_OUTPUT_VARIABLE SAGITTA_EIGEN_FACTS)
list(LENGTH SAGITTA_EIGEN_FACTS SAGITTA_EIGEN_COUNT)
if(NOT SAGITTA_EIGEN_COUNT EQUAL 6)
  message(FATAL_ERROR "Eigen does not say how it aligns matrices: ${SAGITTA_EIGEN_FACTS}")
endif()
set(SAGITTA_EIGEN_INDEX 0)
foreach(fact WORLD MAJOR MINOR DEFAULT_ALIGN MAX_ALIGN STATIC_ALIGN)
  list(GET SAGITTA_EIGEN_FACTS ${SAGITTA_EIGEN_INDEX} SAGITTA_EIGEN_${fact})
  math(EXPR SAGITTA_EIGEN_INDEX "${SAGITTA_EIGEN_INDEX} + 1")
endforeach()

set(SAGITTA_HEADERS)
sagitta_collect_headers(estimator/sagitta.h SAGITTA_HEADERS)
set(SAGITTA_STAGE ${PROJECT_BINARY_DIR}/include/sagitta)
file(REMOVE_RECURSE ${SAGITTA_STAGE})
configure_file(cmake/version.h.in ${SAGITTA_STAGE}/version.h @ONLY)
foreach(header ${SAGITTA_HEADERS})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${header})
  file(READ ${PROJECT_SOURCE_DIR}/${header} text)
  string(REGEX REPLACE "#include \"(models|problems|estimator)/" "#include \"sagitta/detail/\\1/" text "${text}")
  string(REPLACE "#pragma once\n" "#pragma once\n\n#include \"sagitta/version.h\"\n" text "${text}")
  set(target ${SAGITTA_STAGE}/detail/${header})
  if(header STREQUAL "estimator/sagitta.h")
    set(target ${SAGITTA_STAGE}/sagitta.h)
  endif()
  file(WRITE ${target} "${text}")
endforeach()

install(DIRECTORY ${SAGITTA_STAGE} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(TARGETS sagitta sagitta-reproduce RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(DIRECTORY problems/published DESTINATION ${CMAKE_INSTALL_DATADIR}/sagitta COMPONENT program)

install(DIRECTORY ${PROJECT_BINARY_DIR}/shell_pages/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/shell_pages/bash/sagitta
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/shell_pages/zsh/_sagitta
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)

target_compile_features(sagitta_models INTERFACE cxx_std_17)
set_target_properties(sagitta_models PROPERTIES EXPORT_NAME models)
set_target_properties(sagitta_problems PROPERTIES EXPORT_NAME problems)
set_target_properties(sagitta_estimator PROPERTIES EXPORT_NAME sagitta)
install(TARGETS sagitta_models sagitta_problems sagitta_estimator EXPORT sagitta
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT sagitta NAMESPACE sagitta:: FILE sagitta-targets.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sagitta COMPONENT development)
configure_package_config_file(cmake/sagitta-config.cmake.in ${PROJECT_BINARY_DIR}/sagitta-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sagitta)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sagitta-config-version.cmake COMPATIBILITY SameMinorVersion)
# Found from where the file lies: packages and --prefix put it elsewhere than CMAKE_INSTALL_PREFIX. fcl is no Requires:
# Debian's fcl.pc states -std=c++11, which would come after the user's, as ours would.
file(RELATIVE_PATH SAGITTA_PREFIX_FROM_PKGCONFIG "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" SAGITTA_PREFIX_FROM_PKGCONFIG "${SAGITTA_PREFIX_FROM_PKGCONFIG}")
configure_file(cmake/sagitta.pc.in ${PROJECT_BINARY_DIR}/sagitta.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/sagitta-config.cmake ${PROJECT_BINARY_DIR}/sagitta-config-version.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sagitta COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/sagitta.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
