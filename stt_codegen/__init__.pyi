from stt_codegen.api import BadInput as BadInput
from stt_codegen.api import Box as Box
from stt_codegen.api import Certificate as Certificate
from stt_codegen.api import Controller as Controller
from stt_codegen.api import Finding as Finding
from stt_codegen.api import MissingTool as MissingTool
from stt_codegen.api import NotCertified as NotCertified
from stt_codegen.api import SttError as SttError
from stt_codegen.api import Task as Task
from stt_codegen.api import UnsafeBall as UnsafeBall
from stt_codegen.api import UnsafeCapsule as UnsafeCapsule
from stt_codegen.api import UnsafeHalfSpaces as UnsafeHalfSpaces
from stt_codegen.api import UnsafePolytope as UnsafePolytope
from stt_codegen.api import UnsafeSet as UnsafeSet
from stt_codegen.api import build as build
from stt_codegen.api import certify as certify
from stt_codegen.api import certify_tube as certify_tube
from stt_codegen.api import design as design
from stt_codegen.api import load as load
from stt_codegen.api import parse as parse

__version__: str
