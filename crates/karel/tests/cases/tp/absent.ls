/PROG  ABSENT
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  VISION RUN_FIND 'A' ;
   2:  VISION GET_OFFSET 'A' VR[1] JMP LBL[1] ;
   3:  PR[1]=VR[1].OFFSET ;
   4:  IF VR[R[1]].MODELID=1,JMP LBL[1] ;
   5:L P[1] 50mm/sec FINE VOFFSET,VR[1] Offset,PR[1] ;
   6:L P[1] 50mm/sec FINE EV50% ;
   7:J P[1] 50% FINE COORD ;
   8:  LOCK VREG ;
   9:  Arc Start[1] ;
  10:  SPOT[SD=1,P=1] ;
  11:  Search Start[1] PR[3] ;
  12:  Track TAST[1] ;
  13:  LINE[1] ON ;
  14:  PALLETIZING-B_3 ;
  15:  SEND R[1] ;
  16:  ERROR_PROG=ACTION ;
  17:  RESUME_PROG[1]=ACTION ;
  18:  UFrame_Start[1] ;
  19:  Detect_Point[1] UFrame[-Z] ;
  20:  JOINT_MAX_SPEED[1]=50 ;
  21:  LINEAR_MAX_SPEED=500 ;
  22:  LBL[1] ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
/END
