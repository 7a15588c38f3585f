# What is left out of the daemon by platform. platform/ has a file for each kind of system. The broker (--keys) is POSIX's:
# on Windows server/serve_users_windows.cpp stands for it.
set(lappet_broker_files "(broker[a-z_]*|child_limits|gate|key_file|keys_folder|listener|private_folder|serve_users|solver_process|zap)")

function(lappet_of_this_platform sources_variable)
  set(sources ${${sources_variable}})
  if(WIN32)
    list(FILTER sources EXCLUDE REGEX "_posix\\.cpp$")
    list(FILTER sources EXCLUDE REGEX "/server/${lappet_broker_files}(_test)?\\.cpp$")
  else()
    list(FILTER sources EXCLUDE REGEX "_windows\\.cpp$")
  endif()
  set(${sources_variable} ${sources} PARENT_SCOPE)
endfunction()
