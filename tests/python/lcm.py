"""The part of LCM's Python module that the example uses, over liblcm: Debian has no package of the module."""
import ctypes

_lib = ctypes.CDLL("liblcm.so.1")


class _Received(ctypes.Structure):
    _fields_ = [("data", ctypes.c_void_p), ("data_size", ctypes.c_uint32), ("recv_utime", ctypes.c_int64), ("lcm", ctypes.c_void_p)]


_Handler = ctypes.CFUNCTYPE(None, ctypes.POINTER(_Received), ctypes.c_char_p, ctypes.c_void_p)
_lib.lcm_create.restype = ctypes.c_void_p
_lib.lcm_create.argtypes = [ctypes.c_char_p]
_lib.lcm_subscribe.restype = ctypes.c_void_p
_lib.lcm_subscribe.argtypes = [ctypes.c_void_p, ctypes.c_char_p, _Handler, ctypes.c_void_p]
_lib.lcm_publish.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint]
_lib.lcm_handle_timeout.argtypes = [ctypes.c_void_p, ctypes.c_int]


class LCM:
    def __init__(self, url=""):
        self._lcm, self._handlers = _lib.lcm_create(url.encode()), []
        if not self._lcm:
            raise RuntimeError("cannot open LCM")

    def subscribe(self, channel, handler):
        def handle(received, name, _):
            handler(name.decode(), ctypes.string_at(received.contents.data, received.contents.data_size))

        self._handlers.append(_Handler(handle))  # as long as LCM may call it
        _lib.lcm_subscribe(self._lcm, channel.encode(), self._handlers[-1], None)

    def publish(self, channel, data):
        _lib.lcm_publish(self._lcm, channel.encode(), data, len(data))

    def handle_timeout(self, timeout_ms):
        return _lib.lcm_handle_timeout(self._lcm, timeout_ms)
