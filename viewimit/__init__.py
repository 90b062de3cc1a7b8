"""viewimit"""
