# Unity builds: a source costs its headers far more than its own lines, so several of one target are compiled as one.
#
#   twin_unity(target)   for a target with more than a few sources
#
# Names in anonymous namespaces are therefore unique within an area. -DTWIN_UNITY=OFF compiles each source alone, which is
# quicker while one file changes (preset dev), and what scripts/lint looks at.
option(TWIN_UNITY "Compile several sources of a target as one" ON)

function(twin_unity target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TWIN_UNITY} UNITY_BUILD_BATCH_SIZE 10)
  if(TWIN_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # a class of one source may have members of types local to it
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
endfunction()
