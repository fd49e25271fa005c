# Run by cpack on the files of the packages before they are packed: compresses manuals, and adds what
# Debian wants in /usr/share/doc.
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(root ${CPACK_TEMPORARY_DIRECTORY}/${component})
  if(NOT IS_DIRECTORY ${root})
    continue()
  endif()
  string(TOUPPER ${component} upper)
  set(name ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(doc ${root}/usr/share/doc/${name})
  file(READ ${CPACK_PLANISH_SOURCE}/LICENSE license)
  string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
  string(REGEX REPLACE "\n([^\n])" "\n \\1" license "${license}")
  string(STRIP "${license}" license)
  set(compiled_in)
  set(programs ${component})
  set(gpl)
  if(EXISTS ${root}/usr/bin/planish-reconstruct)
    list(APPEND programs planish-reconstruct)
    set(gpl "
Files: src/planish/reconstruct/cgal/*
Copyright: 2026 The planish authors
License: GPL-3+
 The program /usr/bin/planish-reconstruct contains CGAL's surface reconstruction, whose authors are named in
 copyright.libcgal-dev beside this file. It is free software under the GNU General Public License, version 3
 or later, whose text stands in /usr/share/common-licenses/GPL-3. Its source is this folder of planish, and
 CGAL.
")
  endif()
  # Code of others that is compiled in: what Debian says of it stands beside.
  foreach(program IN LISTS programs)
    file(STRINGS ${CPACK_PLANISH_SOURCE}/tools/portable/compiled_in lines REGEX "^${program} ")
    list(TRANSFORM lines REPLACE "^${program} " "")
    list(APPEND compiled_in ${lines})
  endforeach()
  list(REMOVE_DUPLICATES compiled_in)
  file(MAKE_DIRECTORY ${doc})
  foreach(package IN LISTS compiled_in)
    file(COPY_FILE /usr/share/doc/${package}/copyright ${doc}/copyright.${package})
  endforeach()
  set(others)
  if(compiled_in)
    list(JOIN compiled_in "\n copyright." names)
    set(others "Comment:
 Code of other projects is compiled in. Their licences stand beside this file:
 copyright.${names}
")
  endif()
  file(CONFIGURE OUTPUT ${doc}/copyright @ONLY CONTENT
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
@others@
Files: *
Copyright: 2026 The planish authors
License: Expat
 @license@
@gpl@")
  set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
  file(WRITE ${doc}/changelog.Debian
"planish (${version}) unstable; urgency=medium

  * CHANGELOG.md of the source says what is new.

 -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${now}
")
  file(COPY_FILE ${CPACK_PLANISH_SOURCE}/CHANGELOG.md ${doc}/changelog)
  file(GLOB texts ${root}/usr/share/man/man1/*.1)
  foreach(text IN ITEMS ${texts} ${doc}/changelog ${doc}/changelog.Debian)
    if(text)
      execute_process(COMMAND gzip -9nf ${text} COMMAND_ERROR_IS_FATAL ANY)
    endif()
  endforeach()
endforeach()
