// The bodies of the header-only Boost libraries, compiled once (separate compilation keeps every other unit small).
#include <boost/asio/impl/src.hpp>
#include <boost/asio/ssl/impl/src.hpp>
#include <boost/beast/src.hpp>
#include <boost/json/src.hpp>
