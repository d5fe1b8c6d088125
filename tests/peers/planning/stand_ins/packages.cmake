# In place of VAMP's cmake/FetchInitCPM.cmake, which downloads what no package registry has: what it asks for is taken from here, and nanobind from PyPI.
macro(CPMAddPackage what)
  if("${what}" MATCHES "/([A-Za-z]+)#")
    set(_name "${CMAKE_MATCH_1}")
    if(_name STREQUAL "nanobind")
      execute_process(
        COMMAND "${Python_EXECUTABLE}" -m nanobind --cmake_dir OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE nanobind_ROOT
      )
      find_package(nanobind CONFIG REQUIRED)
    elseif(EXISTS "${STAND_INS}/${_name}")
      set(${_name}_SOURCE_DIR "${STAND_INS}/${_name}")
    endif()
  endif()
endmacro()
