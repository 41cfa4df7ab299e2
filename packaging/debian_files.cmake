# Run by CPack in each package's tree before it becomes a package: what Debian wants in every one.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
set(changelog "dacrt (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * What is new is said in CHANGELOG.md.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(share ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr/share)
  set(doc ${share}/doc/${component})
  file(WRITE ${doc}/changelog "${changelog}")
  configure_file(${DACRT_SOURCE_DIR}/CHANGELOG.md ${doc}/CHANGELOG.md COPYONLY)
  configure_file(${DACRT_SOURCE_DIR}/packaging/copyright ${doc}/copyright COPYONLY)
  file(GLOB pages ${share}/man/man*/*.1)
  execute_process(COMMAND gzip -9n ${doc}/changelog ${doc}/CHANGELOG.md ${pages}
                  COMMAND_ERROR_IS_FATAL ANY)
endforeach()
