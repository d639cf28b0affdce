"""Flows of a surface over a volume (3.4)."""

from shapery_segmentation.flow.normal import normal_flow
from shapery_segmentation.flow.params import FlowResult, FlowState, NormalFlowParams, StageRecord

__all__ = ["FlowResult", "FlowState", "NormalFlowParams", "StageRecord", "normal_flow"]
