# What planish uses of oneTBB, on the one thread that WebAssembly without headers of the server has.
if(NOT TARGET TBB::tbb)
  add_library(TBB::tbb INTERFACE IMPORTED)
  target_include_directories(TBB::tbb INTERFACE ${CMAKE_CURRENT_LIST_DIR})
endif()
