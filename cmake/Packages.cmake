# cpack -G DEB: sagitta (programs and published data), python3-sagitta, libsagitta-dev. What each needs of shared
# libraries is found by dpkg-shlibdeps.
set(CPACK_PACKAGE_NAME sagitta)
set(CPACK_PACKAGE_VENDOR Sagitta)
set(CPACK_PACKAGE_CONTACT "Sagitta maintainers <maintainers@sagitta.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Offline estimator for robot calibration")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_ALL program development)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME sagitta)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "Offline estimator for robot calibration
 Estimates geometry, joint compliances and gravity compensator of a robot arm
 from measured points, and names what the model lacks.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libsagitta-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libceres-dev, libeigen3-dev, libyaml-cpp-dev, nlohmann-json3-dev, \
libssl-dev, liburdfdom-dev, libexpat1-dev, libfmt-dev, libhwy-dev, libfcl-dev, \
libgoogle-glog-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Offline estimator for robot calibration: library and headers
 What programs of your own need to link sagitta::sagitta.")

if(TARGET sagitta_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-sagitta)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # The module is built for one minor version of the interpreter.
  math(EXPR SAGITTA_PYTHON_NEXT "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${SAGITTA_PYTHON_NEXT}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS python3-pandas)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, sagitta")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "Offline estimator for robot calibration: Python module
 import sagitta: calibrate, diagnose, predict, plan and compensate from files,
 NumPy arrays and pandas frames.")
endif()
include(CPack)
