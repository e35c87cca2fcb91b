# Hardens Release builds as Debian hardens its packages (dpkg-buildflags, hardening=+all), and with CET: stack protector and
# stack clash protection, _FORTIFY_SOURCE, endbr64 at the targets of indirect branches, full RELRO. PIE is the default of
# Debian's compiler. Not with sanitizers, which find more. hardening_test (tests/security) checks the program.
option(TWIN_HARDENING "Harden what is compiled for Release, as Debian does" ON)
if(TWIN_HARDENING AND CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  add_compile_options(-fstack-protector-strong -fstack-clash-protection -Wformat -Werror=format-security)
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    add_compile_options(-fcf-protection)
  endif()
  # Beside -O3, because libc refuses it without optimisation; tests' own sources take it back.
  string(APPEND CMAKE_CXX_FLAGS_RELEASE " -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2")
  string(APPEND CMAKE_C_FLAGS_RELEASE " -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2")
  add_link_options(-Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack)
endif()
