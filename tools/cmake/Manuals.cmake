# Whether what is built runs here.
set(PLANISH_RUNS_HERE ON)
if(EMSCRIPTEN OR (CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR))
  set(PLANISH_RUNS_HERE OFF)
endif()

# planish_install_manuals(TARGET COMPONENT PAGE=ARGUMENTS...): manual pages that a program prints of its own
# flags when it is given these arguments, installed for section 1.
function(planish_install_manuals target component)
  if(NOT PLANISH_RUNS_HERE)
    return()
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/help)
  file(MAKE_DIRECTORY ${folder})
  set(pages)
  set(commands)
  foreach(entry IN LISTS ARGN)
    string(REGEX MATCH "^([^=]+)=(.+)$" unused "${entry}")
    set(page ${folder}/${CMAKE_MATCH_1})
    separate_arguments(arguments UNIX_COMMAND "${CMAKE_MATCH_2}")
    list(APPEND pages ${page})
    list(APPEND commands COMMAND ${target} ${arguments} > ${page})
  endforeach()
  add_custom_command(OUTPUT ${pages} ${commands} DEPENDS ${target} VERBATIM
                     COMMENT "Printing manuals of ${target}")
  add_custom_target(${target}_manuals ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
endfunction()
