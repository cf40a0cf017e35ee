# What `cmake --install` puts below a prefix, and the Debian package that scripts/package.sh makes of it.
include(GNUInstallDirs)
set(deploy ${PROJECT_SOURCE_DIR}/docs/deploy)

install(TARGETS sightline RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET sightline_convert)
  install(TARGETS sightline_convert RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT convert EXCLUDE_FROM_ALL)
endif()
install(FILES ${deploy}/sightline.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${deploy}/nginx.conf ${deploy}/nginx-stream.conf ${deploy}/sightline.json
        DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
install(FILES ${PROJECT_SOURCE_DIR}/proto/python/sightline.py ${PROJECT_SOURCE_DIR}/proto/python/sightline_bulk.py
        DESTINATION lib/python3/dist-packages)

# The unit of docs/deploy is for a binary that was copied to /usr/local; the package has it in /usr.
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${deploy}/sightline.service)
file(READ ${deploy}/sightline.service unit)
string(REPLACE "/usr/local/bin/" "/usr/bin/" unit "${unit}")
file(WRITE ${PROJECT_BINARY_DIR}/package/sightline.service "${unit}")
install(FILES ${PROJECT_BINARY_DIR}/package/sightline.service DESTINATION lib/systemd/system)
install(FILES ${deploy}/debian/sysusers.conf DESTINATION lib/sysusers.d RENAME sightline.conf)
install(FILES ${deploy}/sightline.json DESTINATION /etc/sightline)

file(STRINGS /etc/os-release os_version REGEX "^VERSION_ID=")
string(REGEX REPLACE "[^0-9]" "" os_version "${os_version}")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sightline)
set(CPACK_PACKAGE_VENDOR sightline)
set(CPACK_PACKAGE_CONTACT "Sightline <sightline@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Exact ray queries against 3D scenes over HTTP")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
    "A server that answers line of sight, LiDAR, picking, distance and shadow queries for glTF scenes. Every answer is exact.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE "1~deb${os_version}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "passwd")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "ca-certificates")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "nginx, python3-numpy")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${deploy}/debian/conffiles ${deploy}/debian/postinst ${deploy}/debian/prerm
                                       ${deploy}/debian/postrm)
include(CPack)
